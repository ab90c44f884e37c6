// SPDX-License-Identifier: Apache-2.0
#include "server/app/priors/level_apart.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/graph/graph_optimization.h"
#include "core/graph/plans/plan_placement.h"
#include "core/graph/plans/shafts.h"
#include "core/prior/fit/join_maps.h"
#include "core/prior/ties/find_ties.h"
#include "fmt/format.h"

namespace enfilade::server {
namespace {

// Those in use of other levels that have a place in the world.
std::vector<graph::PlacedPlan> PlansOfOtherLevels(const graph::GraphSnapshot& graph,
                                                  const storage::PriorMap& prior_map) {
  graph::SolvedGraph solution;
  solution.map_poses[graph.root()] = {};
  if (graph.solution() != nullptr && graph.solution()->root == graph.root()) solution = *graph.solution();
  std::vector<const graph::PlanInGraph*> plans;
  for (const graph::PlanInGraph& plan : graph.plans()) {
    if (plan.id != prior_map.id && plan.level != prior_map.level) plans.push_back(&plan);
  }
  return graph::PlacePlans(graph, solution, plans);
}

// The graph as if the plan was used with these ties, solved; none if it shares no shaft with a plan in use of another
// level. Without other plans of its level: this one may be to replace them.
absl::StatusOr<std::optional<graph::SolvedGraph>> TrySolving(const graph::GraphSnapshot& graph,
                                                             const storage::PriorMap& prior_map,
                                                             const graph::PlanTies& ties) {
  std::vector<graph::PlanInGraph> plans;
  bool shares_any = false;
  for (const graph::PlanInGraph& plan : graph.plans()) {
    if (plan.id == prior_map.id || plan.level == prior_map.level) continue;
    shares_any |= !graph::SameShafts(ties, *plan.ties).empty();
    plans.push_back(plan);
  }
  if (!shares_any || graph.root().empty()) return std::optional<graph::SolvedGraph>();
  plans.push_back(
      {.id = prior_map.id, .ties = std::make_shared<const graph::PlanTies>(ties), .level = prior_map.level});
  std::sort(plans.begin(), plans.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  ENFILADE_ASSIGN_OR_RETURN(const graph::GraphSnapshot with,
                            graph::Apply(graph, {.version = graph.version(), .plans = std::move(plans)}));
  ENFILADE_ASSIGN_OR_RETURN(graph::SolvedGraph solution, graph::OptimizeGraph(with));
  return std::optional(std::move(solution));
}

absl::StatusOr<grid::OccupancyGrid> JoinedMaps(const std::vector<LevelMap>& maps) {
  std::vector<prior::PlacedMap> placed;
  for (const LevelMap& map : maps) placed.push_back({&map.grid, &map.evidence, map.T_world_map});
  return prior::Overlaid(placed);
}

// Where the level lies by the solution; none if that poses none of its maps.
std::optional<Pose2> PlaceOf(const LevelMaps& level, const graph::SolvedGraph& solution) {
  std::optional<Pose2> T_world_level;
  std::size_t most = 0;
  for (const LevelMap& map : level.maps) {
    const auto posed = solution.map_poses.find(map.id);
    if (posed == solution.map_poses.end() || map.evidence.walls.size() <= most) continue;
    most = map.evidence.walls.size();
    T_world_level = posed->second.pose * Inverse(map.T_world_map);
  }
  return T_world_level;
}

}  // namespace

absl::Status CheckShafts(const prior::PlanGraph& plan, const storage::PriorMap& prior_map, const LevelMaps& level) {
  std::set<std::string> known, shared;
  for (const graph::PlacedPlan& other : PlansOfOtherLevels(level.graph->graph(), prior_map)) {
    for (const graph::ShaftInPlan& shaft : other.plan->ties->shafts) known.insert(shaft.name);
  }
  for (const prior::PlanShaft& shaft : plan.shafts) {
    if (known.contains(shaft.name)) shared.insert(shaft.name);
  }
  if (!level.maps.empty() && shared.size() >= 2) return absl::OkStatus();
  return FailedPrecondition(
      "no map of level {} has walls and is joined to the root map of {}{}", prior_map.level, NameOf(prior_map.site),
      level.maps.empty()
          ? ""
          : fmt::format("; without one the plan needs two named shafts that plans in use of other levels "
                        "have, and has {}",
                        shared.size()));
}

absl::Status LayOutApart(const graph::GraphSnapshot& graph, LevelMaps& level) {
  level.is_apart = true;
  if (level.unjoined.empty()) return absl::OkStatus();
  const MapId base = level.unjoined.front().id;
  ENFILADE_ASSIGN_OR_RETURN(const graph::GraphSnapshot from_base,
                            graph::Apply(graph, {.version = graph.version(), .root = base}));
  ENFILADE_ASSIGN_OR_RETURN(const graph::SolvedGraph solution, graph::OptimizeGraph(from_base));
  const auto joined = std::stable_partition(level.unjoined.begin(), level.unjoined.end(),
                                            [&](const LevelMap& map) { return !solution.map_poses.contains(map.id); });
  level.maps.assign(std::make_move_iterator(joined), std::make_move_iterator(level.unjoined.end()));
  level.unjoined.erase(joined, level.unjoined.end());
  for (LevelMap& map : level.maps) map.T_world_map = solution.map_poses.at(map.id).pose;
  std::sort(level.maps.begin(), level.maps.end(), [](const LevelMap& a, const LevelMap& b) { return a.id < b.id; });
  return absl::OkStatus();
}

absl::StatusOr<ApartLevelPlace> PlaceApartLevel(const prior::PlanGraph& plan, const storage::PriorMap& prior_map,
                                                const LevelMaps& level, const prior::FitOptions& options) {
  const std::vector<graph::PlacedPlan> others = PlansOfOtherLevels(level.graph->graph(), prior_map);
  std::vector<grid::OccupancyGrid> grids(1);
  ENFILADE_ASSIGN_OR_RETURN(grids.front(), JoinedMaps(level.maps));
  ENFILADE_ASSIGN_OR_RETURN(const prior::PlanFit fit, prior::FitPlan(plan, grids, options));
  ApartLevelPlace place{.T_level_sheet = fit.alignment.T_map_sheet,
                        .rival_ratio = fit.alignment.rival_ratio,
                        .reason = fit.alignment.reason};
  if (!fit.alignment.accepted) return place;
  std::vector<prior::MapOfPlan> maps;
  for (const LevelMap& map : level.maps) maps.push_back({map.id, &map.evidence, map.T_world_map});
  const graph::PlanTies ties = prior::FindTies(plan, place.T_level_sheet, *fit.corrected, maps);
  const graph::ShaftPlacement by_shafts = graph::PlaceByShafts(ties, prior_map.level, others);
  if (!by_shafts.T_world_plan) {
    place.reason = fmt::format("no map of the level is joined to the root map, and {}", by_shafts.reason);
    return place;
  }
  ENFILADE_ASSIGN_OR_RETURN(const auto solution, TrySolving(level.graph->graph(), prior_map, ties));
  if (solution) place.T_world_level = PlaceOf(level, *solution);
  const std::string shafts = fmt::format("{}", fmt::join(by_shafts.shafts, ", "));
  place.reason = place.T_world_level
                     ? fmt::format("{}; no map of the level is joined to the root map: the shafts {} say where it lies",
                                   place.reason, shafts)
                     : fmt::format(
                           "no map of the level is joined to the root map, and the shafts {} do not tell to 1 m "
                           "and 5 degrees where it lies",
                           shafts);
  return place;
}

absl::StatusOr<std::string> ObjectionOfShafts(const graph::GraphSnapshot& graph, const storage::PriorMap& prior_map,
                                              const graph::PlanTies& ties) {
  ENFILADE_ASSIGN_OR_RETURN(const auto solution, TrySolving(graph, prior_map, ties));
  if (!solution) return std::string();
  const auto use = std::find_if(solution->plans.begin(), solution->plans.end(),
                                [&](const graph::PlanUse& one) { return one.plan == prior_map.id; });
  if (use == solution->plans.end()) return std::string();
  const auto is_off = [](const graph::ShaftUse& shaft) { return !shaft.used; };
  const auto off = std::count_if(use->shafts.begin(), use->shafts.end(), is_off);
  if (2 * off <= static_cast<std::ptrdiff_t>(use->shafts.size())) return std::string();
  const graph::ShaftUse& first = *std::find_if(use->shafts.begin(), use->shafts.end(), is_off);
  return fmt::format("{} of its {} shafts lie elsewhere than on other levels: {} is {:.1f} m away from where {} has it",
                     off, use->shafts.size(), first.name, first.distance, NameOf(prior_map.site, first.other));
}

}  // namespace enfilade::server
