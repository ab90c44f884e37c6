// SPDX-License-Identifier: Apache-2.0
#include "core/graph/plans/plan_placement.h"

#include <algorithm>
#include <cstddef>
#include <optional>

namespace enfilade::graph {
namespace {

// By the map that sees most of it, of those that the solution poses.
std::optional<Pose2> PlaceByMaps(const GraphSnapshot& graph, const SolvedGraph& solution, const PlanTies& ties) {
  std::optional<Pose2> T_world_plan;
  std::ptrdiff_t most = 0;
  for (const MapInPlan& map : ties.maps) {
    const auto known = solution.map_poses.find(map.map);
    const auto seen = std::count_if(ties.sightings.begin(), ties.sightings.end(),
                                    [&](const WallSighting& sighting) { return sighting.map == map.map; });
    if (known == solution.map_poses.end() || graph.MapSlot(map.map) < 0 || seen <= most) continue;
    most = seen;
    T_world_plan = known->second.pose * Inverse(map.T_plan_map);
  }
  return T_world_plan;
}

}  // namespace

std::vector<PlacedPlan> PlacePlans(const GraphSnapshot& graph, const SolvedGraph& solution,
                                   const std::vector<const PlanInGraph*>& plans) {
  std::vector<PlacedPlan> placed;
  std::vector<const PlanInGraph*> others;
  for (const PlanInGraph* plan : plans) {
    const std::optional<Pose2> T_world_plan = PlaceByMaps(graph, solution, *plan->ties);
    if (T_world_plan) {
      placed.push_back({plan, *T_world_plan});
    } else {
      others.push_back(plan);
    }
  }
  for (std::size_t before = placed.size() + 1; before != placed.size() && !others.empty();) {
    before = placed.size();
    std::erase_if(others, [&](const PlanInGraph* plan) {
      const ShaftPlacement by_shafts = PlaceByShafts(*plan->ties, plan->level, placed);
      if (by_shafts.T_world_plan) placed.push_back({plan, *by_shafts.T_world_plan});
      return by_shafts.T_world_plan.has_value();
    });
  }
  return placed;
}

}  // namespace enfilade::graph
