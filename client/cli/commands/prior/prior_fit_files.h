// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"
#include "core/prior/alignment/control_pairs.h"
#include "core/prior/correction/correct_plan.h"
#include "core/prior/fit/planning_map.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::cli {

// Lines of numbers with commas between them; empty lines and those that begin with # are left out. INVALID_ARGUMENT:
// naming the line.
absl::StatusOr<std::vector<prior::ControlPair>> ReadPairs(const std::filesystem::path& path);
absl::StatusOr<std::vector<Eigen::Vector2d>> ReadSheetPoints(const std::filesystem::path& path);

std::string_view NameOf(prior::Sight sight);  // seen, unseen, contradicted

// A GeoJSON FeatureCollection in the map's frame (m, y upwards): each wall with `state`, `stretch` and `sigma_m`.
std::string WriteCorrectedPlan(const prior::PlanGraph& plan, const prior::CorrectedPlan& corrected);
// plan_x_px,plan_y_px,input_x_m,input_y_m,sigma_m,state
std::string WriteLocatedPoints(const std::vector<Eigen::Vector2d>& points, const prior::CorrectedPlan& corrected);
// A PNG: the map, the plan as it was placed (grey) and corrected (seen green, unseen blue, contradicted red).
absl::StatusOr<std::string> DrawFit(const grid::OccupancyGrid& map, const prior::PlanGraph& plan,
                                    const prior::PlanTransform& T_map_sheet, const prior::CorrectedPlan& corrected);

// A grey PNG, a pixel for each cell: 0 unknown, 1 seen by a robot, 2 predicted by the plan.
absl::StatusOr<std::string> DrawMask(const prior::PlanningMap& planning);

}  // namespace enfilade::cli
