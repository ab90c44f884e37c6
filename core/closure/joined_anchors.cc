// SPDX-License-Identifier: Apache-2.0
#include "core/closure/joined_anchors.h"

#include "core/graph/paths/pose_chain.h"
#include "core/graph/same_place.h"

namespace enfilade::closure {

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
    if (link_point->use == graph::LinkPointUse::kSuspended) continue;
    if (graph::FindCommonPlace(link_point->anchors, {anchors.here, anchors.there})) return link_point;
  }
  return nullptr;
}

}  // namespace enfilade::closure
