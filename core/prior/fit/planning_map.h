// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"
#include "core/prior/correction/correct_plan.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

enum class CellSource : std::uint8_t {
  kUnknown = 0,
  kSeen = 1,       // by a robot
  kPredicted = 2,  // by the plan
};

// A map to plan ways with: what robots have seen, and the plan where they have seen nothing.
struct PlanningMap {
  grid::OccupancyGrid map;
  std::vector<CellSource> sources;  // of each cell
};

// The cells of `seen` that are known stay as they are, byte by byte. Of the others those on walls of the corrected
// plan, unless these are contradicted, become occupied, and those in its rooms free. The lattice is that of `seen`,
// made large enough for the plan. `evidence`: of `seen`. INVALID_ARGUMENT: more than grid::kMaxRasterCells.
absl::StatusOr<PlanningMap> MakePlanningMap(const grid::OccupancyGrid& seen, const MapEvidence& evidence,
                                            const PlanGraph& plan, const CorrectedPlan& corrected);

// The corrected plan as a plan again: its unit is the metre, and a point (x, y) of the map is (x, -y).
PlanGraph CorrectedGraph(const PlanGraph& plan, const CorrectedPlan& corrected);

}  // namespace enfilade::prior
