// SPDX-License-Identifier: Apache-2.0
#include "server/app/localization/robot_localization.h"

#include <chrono>
#include <memory>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/graph/global_pose.h"
#include "server/app/localization/call_progress.h"

namespace enfilade::server {
namespace {

// Counts a search while it runs.
class SearchSlot {
 public:
  SearchSlot(std::atomic<int>& searches, int limit) : searches_(searches), taken_(++searches <= limit) {}
  ~SearchSlot() { --searches_; }
  SearchSlot(const SearchSlot&) = delete;
  SearchSlot& operator=(const SearchSlot&) = delete;

  bool taken() const { return taken_; }

 private:
  std::atomic<int>& searches_;
  const bool taken_;
};

absl::Status CheckPrior(const SiteId& site, const LocalizationPrior& prior, const graph::GraphSnapshot& graph) {
  if (prior.T_map_robot && !prior.map) return InvalidArgument("the prior has a pose, but not the map that it is in");
  if (prior.map && graph.FindMap(*prior.map) == nullptr) {
    return NotFound("site {} has no map {}", site.value(), prior.map->value());
  }
  return absl::OkStatus();
}

// The maps that the prior allows, with the prior's pose in each of them.
absl::StatusOr<std::vector<std::pair<MapId, std::optional<PoseWithCovariance>>>> AllowedMaps(
    const graph::GraphSnapshot& graph, const LocalizationPrior& prior) {
  std::vector<std::pair<MapId, std::optional<PoseWithCovariance>>> allowed;
  std::optional<graph::TransformsTo> transforms;
  if (prior.T_map_robot) {
    ENFILADE_ASSIGN_OR_RETURN(transforms, graph::TransformsTo::Make(graph, *prior.map));
  }
  for (const graph::MapInGraph* map : graph.ListMaps()) {
    if (prior.level && map->level != *prior.level) continue;
    if (!transforms) {
      if (!prior.map || map->id == *prior.map) allowed.emplace_back(map->id, std::nullopt);
      continue;
    }
    ENFILADE_ASSIGN_OR_RETURN(const auto T_map_prior, transforms->Find(map->id));
    if (T_map_prior) allowed.emplace_back(map->id, Compose(T_map_prior->T_a_b, *prior.T_map_robot));
  }
  return allowed;
}

}  // namespace

absl::StatusOr<std::vector<RobotLocalization::Candidate>> RobotLocalization::FindCandidates(
    const storage::CallContext& context, const SiteId& site, const graph::GraphSnapshot& graph,
    const LocalizationPrior& prior) const {
  std::vector<Candidate> candidates;
  ENFILADE_ASSIGN_OR_RETURN(const auto allowed, AllowedMaps(graph, prior));
  for (const auto& [map, T_map_robot] : allowed) {
    ENFILADE_RETURN_IF_ERROR(CheckProgress(context));
    auto revision = revisions_.Get(context, site, map, 0);
    if (absl::IsNotFound(revision.status())) continue;  // nothing was mapped yet
    ENFILADE_RETURN_IF_ERROR(revision.status());
    candidates.push_back({*std::move(revision), T_map_robot});
  }
  return candidates;
}

absl::Status RobotLocalization::LocateScans(const storage::CallContext& context, const SiteId& site,
                                            const SiteGraph& graph, const LocalizationQuery& query,
                                            LocalizationAnswer& answer) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<Candidate> candidates,
                            FindCandidates(context, site, graph.graph(), query.prior));
  std::vector<localization::CandidateMap> maps;
  for (const Candidate& candidate : candidates) {
    ENFILADE_ASSIGN_OR_RETURN(const auto in_world, graph.poses.Find(candidate.revision.map));
    maps.push_back({[&] { return maps_.Get(context, candidate.revision); }, candidate.T_map_robot,
                    in_world ? std::optional(in_world->T_world_robot.pose) : std::nullopt});
  }
  answer.maps_searched = static_cast<int>(maps.size());
  ENFILADE_ASSIGN_OR_RETURN(localization::Localization found,
                            localization::Localize(query.scans, maps, localization::LocalizationOptions(),
                                                   [&] { return CheckProgress(context); }));
  answer.reason = maps.empty() ? "there is no map to search" : std::move(found.reason);
  for (const localization::LocatedPose& pose : found.poses) {
    const MapId& map = candidates[pose.map].revision.map;
    ENFILADE_ASSIGN_OR_RETURN(const auto in_world, graph.poses.Find(map, pose.T_map_robot));
    answer.poses.push_back({map, pose.T_map_robot, in_world ? std::optional(in_world->T_world_robot) : std::nullopt,
                            pose.score, pose.odds_behind, pose.confident});
  }
  return absl::OkStatus();
}

absl::StatusOr<LocalizationAnswer> RobotLocalization::Localize(const storage::CallContext& context, const SiteId& site,
                                                               const LocalizationQuery& query) {
  if (query.scans.empty() && !query.image) return InvalidArgument("there are neither scans nor an image");
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, graphs_.Get(context, site));
  ENFILADE_RETURN_IF_ERROR(CheckPrior(site, query.prior, graph->graph()));
  const SearchSlot slot(searches_, kMaxSearches);
  if (!slot.taken()) return ResourceExhausted("{} robots are being located already: call again", kMaxSearches);
  LocalizationAnswer answer;
  answer.graph_version = graph->graph().version();
  if (!query.scans.empty()) ENFILADE_RETURN_IF_ERROR(LocateScans(context, site, *graph, query, answer));
  if (query.image) {
    ENFILADE_ASSIGN_OR_RETURN(
        answer.places,
        places_.Rank(context, site, graph->graph(),
                     {query.prior.map, query.prior.level, query.prior.T_map_robot.has_value()}, *query.image));
    if (query.scans.empty()) {
      answer.reason = answer.places.empty() ? "no kept image of a place resembles the image"
                                            : "an image shows which place the robot is near, not its pose";
    }
  }
  return answer;
}

}  // namespace enfilade::server
