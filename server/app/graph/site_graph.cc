// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/site_graph.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "absl/base/call_once.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::server {

struct SiteGraph::SortedOnce {
  absl::once_flag once;
  Lists lists;
};

SiteGraph::SiteGraph(graph::GraphSnapshot snapshot, PlacedLinkPoints link_points)
    : poses(std::move(snapshot)), placed(std::move(link_points)), lists_(std::make_unique<SortedOnce>()) {}
SiteGraph::SiteGraph(SiteGraph&&) noexcept = default;
SiteGraph::~SiteGraph() = default;

const SiteGraph::Lists& SiteGraph::lists() const {
  absl::call_once(lists_->once, [this] {
    lists_->lists.maps = graph().ListMaps();
    lists_->lists.link_points = graph().ListLinkPoints();
  });
  return lists_->lists;
}

graph::SnapshotChanges ToSnapshotChanges(const storage::GraphChanges& changes) {
  graph::SnapshotChanges out{.version = changes.version, .root = changes.root};
  std::unordered_set<MapId> present;
  for (const storage::GraphMap& map : changes.maps) {
    present.insert(map.id);
    out.maps.push_back({.id = map.id, .display_name = map.display_name, .level = map.level, .outline = map.outline});
  }
  out.removed_link_points = changes.removed_link_points;
  for (const storage::StoredLinkPoint& link_point : changes.link_points) out.link_points.push_back(link_point.point);
  for (const MapId& map : changes.removed_maps) {
    if (!present.contains(map)) out.removed_maps.push_back(map);  // otherwise deleted and created again
  }
  return out;
}

std::shared_ptr<const graph::SolvedGraph> ToSolvedGraph(const std::vector<storage::MapPose>& poses,
                                                        std::int64_t version, const MapId& root) {
  graph::SolvedGraph solved{.graph_version = version, .root = root};
  for (const storage::MapPose& pose : poses) solved.map_poses[pose.map] = pose.T_world_map;
  const auto found = solved.map_poses.find(root);
  // Poses in the world frame of another root.
  if (found == solved.map_poses.end() || found->second.pose != Pose2{} || !found->second.covariance.isZero()) {
    return nullptr;
  }
  return std::make_shared<const graph::SolvedGraph>(std::move(solved));
}

absl::StatusOr<geo::GeoreferenceFit> FitControlPoints(const graph::WorldPoses& poses,
                                                      const std::vector<storage::ControlPoint>& points) {
  std::vector<geo::SurveyPoint> survey;
  for (const storage::ControlPoint& point : points) {
    ENFILADE_ASSIGN_OR_RETURN(const std::optional<graph::GlobalPose> pose, poses.Find(point.map));
    if (!pose.has_value()) {
      return FailedPrecondition("map {} has a control point, but no link points join it to the root map {}",
                                point.map.value(), poses.graph().root().value());
    }
    survey.push_back({.place = {.longitude = point.longitude, .latitude = point.latitude},
                      .p_world = pose->T_world_robot.pose * point.position});
  }
  return geo::FitGeoreference(survey);
}

storage::GraphSolution ToStored(const graph::WorldPoses& solved, const graph::SolvedGraph& solution) {
  storage::GraphSolution out;
  for (const auto& [map, T_world_map] : solution.map_poses) out.maps.push_back({map, T_world_map});
  std::sort(out.maps.begin(), out.maps.end(),
            [](const storage::MapPose& a, const storage::MapPose& b) { return a.map < b.map; });
  for (const graph::LinkPoint* link_point : solved.graph().ListLinkPoints()) {
    if (const auto T_world_place = graph::FindInWorld(solved, *link_point)) {
      out.link_points.push_back({link_point->id, *T_world_place});
    }
    if (link_point->is_candidate() || link_point->use != graph::LinkPointUse::kUsed) continue;
    const auto anchors = static_cast<std::int64_t>(link_point->anchors.size());
    out.residual_count += anchors == 2 ? 1 : anchors;
  }
  for (const graph::SwitchedOff& off : solution.switched_off) out.switched_off.push_back(off.link_point);
  out.chi2_before = solution.chi2_before;
  out.chi2_after = solution.chi2_after;
  return out;
}

}  // namespace enfilade::server
