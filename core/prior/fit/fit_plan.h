// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"
#include "core/prior/alignment/align.h"
#include "core/prior/alignment/control_pairs.h"
#include "core/prior/correction/added_walls.h"
#include "core/prior/correction/correct_plan.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

enum class FitMode {
  kFull,        // the plan is placed and corrected (DisplacementField)
  kAcg,         // the plan is placed and corrected by WallSprings
  kSimilarity,  // the plan is placed: turned, shifted and scaled
  kAffine,      // and stretched and sheared as a whole
};
std::string_view NameOf(FitMode mode);
std::optional<FitMode> FitModeFrom(std::string_view name);

struct FitOptions {
  FitMode mode = FitMode::kFull;
  // Points known in the plan and in the first map; empty: the place is found without help.
  std::vector<ControlPair> pairs = {};
  // Where it lies in the first map, to about a metre: it is looked for there only (AlignFrom). Not with pairs.
  std::optional<PlanTransform> start = std::nullopt;
  int threads = 1;  // AlignOptions::threads
};

// What became of one map.
struct FittedMap {
  Alignment alignment;                              // of the plan in the map's own frame
  std::optional<Pose2> T_first_map = std::nullopt;  // set: it is joined with the first map, by the plan
};

// A plan that lies in one map or more. The frame of all is the first map's.
struct PlanFit {
  std::vector<FittedMap> maps;  // as given
  Alignment alignment;          // of the plan in the joined maps
  // Not set if the plan is not accepted.
  grid::OccupancyGrid map;  // the joined maps
  std::unique_ptr<const MapEvidence> evidence = nullptr;
  std::unique_ptr<const CorrectedPlan> corrected = nullptr;
  std::vector<AddedWall> added = {};  // walls that the plan does not have
};

// Each map is aligned with the plan. The one of which the plan explains most tells the others the plan's shape: its
// scale, its stretch, and whether it is mirrored. All others but the first, if that is accepted, are looked for with
// that shape (AlignOptions::known_shape). Maps in which the plan is accepted are joined by it, those first of which it
// explains most; one that contradicts those before it is left out. The plan is corrected with all of them. It is
// refused if the first map is; and if people have shown a place where even the corrected plan explains less than 35 %
// of the map's walls there, or is contradicted by more than 20 % of what the map knows. INVALID_ARGUMENT: no map, a map
// without walls (named by its number), pairs that determine nothing (FitPairs), maps too large to be joined.
absl::StatusOr<PlanFit> FitPlan(const PlanGraph& plan, const std::vector<grid::OccupancyGrid>& maps,
                                const FitOptions& options);

}  // namespace enfilade::prior
