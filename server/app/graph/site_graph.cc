// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/site_graph.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "absl/base/call_once.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

// Poses that differ by less are equal, m and rad.
constexpr double kSamePoseTolerance = 1e-6;

bool IsSame(const PoseWithCovariance& a, const PoseWithCovariance& b) {
  const Pose2 d = Between(a.pose, b.pose);
  if (d.translation().norm() > kSamePoseTolerance || std::abs(d.yaw) > kSamePoseTolerance) return false;
  return a.covariance.isApprox(b.covariance, kSamePoseTolerance) || (a.covariance.isZero() && b.covariance.isZero());
}

bool IsSame(const std::optional<PoseWithCovariance>& a, const PoseWithCovariance& b) { return a && IsSame(*a, b); }

// Whether the link point lies where it is stored: neither it nor its maps have changed since the last optimisation.
bool IsPlaceKnown(const SiteGraph& before, const graph::GraphSnapshot::LinkPointNode& node,
                  const std::unordered_set<int>& moved_maps) {
  if (before.solution_version == 0 || node.link_point->graph_version > before.solution_version) return false;
  return std::none_of(node.maps.begin(), node.maps.end(), [&](int map) { return moved_maps.contains(map); });
}

}  // namespace

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

std::shared_ptr<const graph::SolvedGraph> ToSolvedGraph(const graph::SolvedGraph* old,
                                                        const storage::MapPoseChanges& changes, std::int64_t version,
                                                        const MapId& root) {
  graph::SolvedGraph solved{.graph_version = version, .root = root};
  if (old != nullptr) solved.map_poses = old->map_poses;
  for (const MapId& map : changes.unposed) solved.map_poses.erase(map);
  for (const storage::MapPose& pose : changes.posed) solved.map_poses[pose.map] = pose.T_world_map;
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

storage::GraphSolution ToStored(const SiteGraph& before, const graph::WorldPoses& solved,
                                const graph::SolvedGraph& solution) {
  storage::GraphSolution out;
  const graph::SolvedGraph* old = before.solution_version == 0 ? nullptr : before.graph().solution();
  out.complete = old == nullptr;
  std::unordered_set<int> moved;  // maps, by slot
  for (const auto& [map, T_world_map] : solution.map_poses) {
    const int slot = solved.graph().MapSlot(map);
    if (slot < 0) continue;
    const PoseWithCovariance* known = old == nullptr ? nullptr : before.graph().FindSolvedPose(map);
    if (known != nullptr && IsSame(*known, T_world_map) && IsSame(before.placed.PlaceOfMap(slot), T_world_map)) {
      continue;
    }
    out.maps.push_back({map, T_world_map});
    moved.insert(slot);
  }
  std::sort(out.maps.begin(), out.maps.end(),
            [](const storage::MapPose& a, const storage::MapPose& b) { return a.map < b.map; });
  if (old != nullptr) {
    for (const auto& [map, T_world_map] : old->map_poses) {
      if (!solution.map_poses.contains(map)) out.unposed.push_back(map);
    }
  }
  for (std::size_t slot = 0; slot < solved.graph().link_point_slots(); ++slot) {
    const auto& node = solved.graph().link_point_node(static_cast<int>(slot));
    if (node.link_point == nullptr) continue;
    const graph::LinkPoint& link_point = *node.link_point;
    const auto place = IsPlaceKnown(before, node, moved) ? std::nullopt : graph::FindInWorld(solved, link_point);
    if (place && !IsSame(before.placed.PlaceOf(static_cast<int>(slot)), *place)) {
      out.link_points.push_back({link_point.id, *place});
    }
    if (link_point.is_candidate() || link_point.use != graph::LinkPointUse::kUsed) continue;
    const auto anchors = static_cast<std::int64_t>(link_point.anchors.size());
    out.residual_count += anchors == 2 ? 1 : anchors;
  }
  std::sort(out.link_points.begin(), out.link_points.end(),
            [](const auto& a, const auto& b) { return a.link_point < b.link_point; });
  for (const graph::SwitchedOff& off : solution.switched_off) out.switched_off.push_back(off.link_point);
  for (const graph::PlanUse& plan : solution.plans) {
    if (!plan.contradiction.empty()) out.contradicted_plans.push_back({plan.plan, plan.contradiction});
  }
  out.chi2_before = solution.chi2_before;
  out.chi2_after = solution.chi2_after;
  out.map_count = static_cast<std::int64_t>(solution.map_poses.size());
  return out;
}

}  // namespace enfilade::server
