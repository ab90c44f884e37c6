#include "core/optimize/edge_error.h"

#include <cmath>

namespace enfilade {

Eigen::Vector3d EdgeError(const Pose2& T_world_from, const Pose2& T_world_to, const Pose2& T_from_to) {
  const Pose2 predicted = Between(T_world_from, T_world_to);
  const double c = std::cos(T_from_to.yaw);
  const double s = std::sin(T_from_to.yaw);
  const double dx = predicted.x - T_from_to.x;
  const double dy = predicted.y - T_from_to.y;
  return {c * dx + s * dy, -s * dx + c * dy, WrapAngle(predicted.yaw - T_from_to.yaw)};
}

LinearizedEdge LinearizeEdge(const Pose2& T_world_from, const Pose2& T_world_to, const Pose2& T_from_to) {
  LinearizedEdge edge;
  edge.error = EdgeError(T_world_from, T_world_to, T_from_to);
  // The translation's error is R(a)^T (t_j - t_i) - R_m^T t_m with a = yaw_i + yaw_m.
  const double c = std::cos(T_world_from.yaw + T_from_to.yaw);
  const double s = std::sin(T_world_from.yaw + T_from_to.yaw);
  const double dx = T_world_to.x - T_world_from.x;
  const double dy = T_world_to.y - T_world_from.y;
  edge.J_from << -c, -s, -s * dx + c * dy,  //
      s, -c, -c * dx - s * dy,              //
      0.0, 0.0, -1.0;
  edge.J_to << c, s, 0.0,  //
      -s, c, 0.0,          //
      0.0, 0.0, 1.0;
  return edge;
}

}  // namespace enfilade
