// SPDX-License-Identifier: Apache-2.0
#include "core/graph/paths/pose_chain.h"

#include <cmath>

namespace enfilade::graph {
namespace {

// d (P * T * Q) / d T: the effect of P's rotation, and of T's yaw on Q's translation.
Eigen::Matrix3d MiddleJacobian(const Pose2& P, const Pose2& T, const Pose2& Q) {
  const double c_T = std::cos(T.yaw);
  const double s_T = std::sin(T.yaw);
  Eigen::Matrix3d turned_by_T = Eigen::Matrix3d::Identity();
  turned_by_T(0, 2) = -s_T * Q.x - c_T * Q.y;
  turned_by_T(1, 2) = c_T * Q.x - s_T * Q.y;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation.topLeftCorner<2, 2>() << std::cos(P.yaw), -std::sin(P.yaw), std::sin(P.yaw), std::cos(P.yaw);
  return rotation * turned_by_T;
}

Eigen::Matrix3d Share(const Pose2& P, const PoseWithCovariance& T, const Pose2& Q) {
  const Eigen::Matrix3d J = MiddleJacobian(P, T.pose, Q);
  return J * T.covariance * J.transpose();
}

}  // namespace

PoseWithCovariance TransformAcross(const Anchor& from, const Anchor& to) {
  return Compose({from.T_map_place, from.covariance}, Inverse(PoseWithCovariance{to.T_map_place, to.covariance}));
}

PoseChain ChainAlong(const GraphSnapshot& graph, const Path& path, const PoseWithCovariance& T_start_map,
                     const PoseWithCovariance& T_map_end) {
  PoseChain chain;
  for (std::size_t i = 0; i < path.link_points.size(); ++i) {
    const LinkPoint& link_point = *graph.link_point_node(path.link_points[i]).link_point;
    const MapId& from = graph.map_node(path.maps[i]).map->id;
    const MapId& to = graph.map_node(path.maps[i + 1]).map->id;
    chain.hops.push_back({.link_point = link_point.id,
                          .from = from,
                          .to = to,
                          .T_from_to = TransformAcross(*link_point.FindAnchor(from), *link_point.FindAnchor(to))});
  }
  // behind[i]: from the frame after hop i to the end.
  std::vector<Pose2> behind(chain.hops.size() + 1, T_map_end.pose);
  for (std::size_t i = chain.hops.size(); i > 0; --i) behind[i - 1] = chain.hops[i - 1].T_from_to.pose * behind[i];

  chain.start_share = Share({}, T_start_map, behind[0]);
  Pose2 before = T_start_map.pose;
  for (std::size_t i = 0; i < chain.hops.size(); ++i) {
    chain.hops[i].share = Share(before, chain.hops[i].T_from_to, behind[i + 1]);
    before = before * chain.hops[i].T_from_to.pose;
  }
  chain.end_share = Share(before, T_map_end, {});

  Eigen::Matrix3d covariance = chain.start_share + chain.end_share;
  for (const PoseHop& hop : chain.hops) covariance += hop.share;
  chain.T_start_end = {before * T_map_end.pose, covariance};
  return chain;
}

}  // namespace enfilade::graph
