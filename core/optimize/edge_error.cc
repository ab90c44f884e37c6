// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/edge_error.h"

#include <cmath>

namespace enfilade::optimize {

EdgeMeasurement::EdgeMeasurement(const Pose2& measured)
    : T_from_to(measured), translation_in_to(-Inverse(measured).translation()) {}

Eigen::Vector3d EdgeError(const Pose2& T_world_from, const Pose2& T_world_to, const EdgeMeasurement& measurement) {
  const double a = T_world_from.yaw + measurement.T_from_to.yaw;
  const double c = std::cos(a);
  const double s = std::sin(a);
  const double dx = T_world_to.x - T_world_from.x;
  const double dy = T_world_to.y - T_world_from.y;
  return {c * dx + s * dy - measurement.translation_in_to.x(), c * dy - s * dx - measurement.translation_in_to.y(),
          WrapAngle(T_world_to.yaw - a)};
}

LinearizedEdge LinearizeEdge(const Pose2& T_world_from, const Pose2& T_world_to, const EdgeMeasurement& measurement) {
  const double a = T_world_from.yaw + measurement.T_from_to.yaw;
  const double c = std::cos(a);
  const double s = std::sin(a);
  const double dx = T_world_to.x - T_world_from.x;
  const double dy = T_world_to.y - T_world_from.y;
  LinearizedEdge edge;
  edge.error = {c * dx + s * dy - measurement.translation_in_to.x(),
                c * dy - s * dx - measurement.translation_in_to.y(), WrapAngle(T_world_to.yaw - a)};
  edge.J_to << c, s, 0.0,  //
      -s, c, 0.0,          //
      0.0, 0.0, 1.0;
  edge.K << 1.0, 0.0, -dy,  //
      0.0, 1.0, dx,         //
      0.0, 0.0, 1.0;
  return edge;
}

}  // namespace enfilade::optimize
