// SPDX-License-Identifier: Apache-2.0
#include "core/closure/joined_anchors.h"

#include <algorithm>

#include "core/graph/paths/pose_chain.h"
#include "core/graph/search_radius.h"

namespace enfilade::closure {
namespace {

constexpr double kSamePlace = 0.3;  // m, as migrations/deploy/link_points.sql has it

bool IsSamePlace(const graph::Anchor& a, const graph::Anchor& b) {
  const double distance = (a.T_map_place.translation() - b.T_map_place.translation()).norm();
  return distance <= std::max(kSamePlace, graph::ErrorEllipse95(a.covariance + b.covariance).semi_major_m);
}

}  // namespace

JoinedAnchors JoinAtDoor(const MapId& here, const Pose2& T_here_robot, const PoseWithCovariance& T_here_door,
                         const MapId& there, const PoseWithCovariance& T_there_robot) {
  const PoseWithCovariance T_robot_door{Between(T_here_robot, T_here_door.pose), Eigen::Matrix3d::Zero()};
  const PoseWithCovariance T_there_door = Compose(T_there_robot, T_robot_door);
  return {.here = {here, T_here_door.pose, T_here_door.covariance},
          .there = {there, T_there_door.pose, T_there_door.covariance}};
}

graph::Anchor OriginAnchor(const MapId& map, const DoorClosureOptions& options) {
  const double variance = options.origin_sigma * options.origin_sigma;
  const double yaw_variance = options.origin_yaw_sigma * options.origin_yaw_sigma;
  return {map, Pose2{}, Eigen::Vector3d(variance, variance, yaw_variance).asDiagonal()};
}

std::optional<PoseWithCovariance> PoseAcross(const graph::LinkPoint& link_point, const MapId& here, const MapId& there,
                                             const PoseWithCovariance& T_here_robot) {
  const graph::Anchor* from = link_point.FindAnchor(here);
  const graph::Anchor* to = link_point.FindAnchor(there);
  if (from == nullptr || to == nullptr) return std::nullopt;
  return Compose(graph::TransformAcross(*to, *from), T_here_robot);
}

const graph::LinkPoint* FindRedundant(const std::vector<const graph::LinkPoint*>& link_points,
                                      const JoinedAnchors& anchors) {
  for (const graph::LinkPoint* link_point : link_points) {
    const graph::Anchor* here = link_point->FindAnchor(anchors.here.map);
    const graph::Anchor* there = link_point->FindAnchor(anchors.there.map);
    if (here == nullptr || there == nullptr || link_point->use == graph::LinkPointUse::kSuspended) continue;
    if (IsSamePlace(*here, anchors.here) && IsSamePlace(*there, anchors.there)) return link_point;
  }
  return nullptr;
}

}  // namespace enfilade::closure
