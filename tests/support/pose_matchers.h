// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <ostream>

#include "core/geometry/pose2.h"

namespace enfilade {

inline void PrintTo(const Pose2& pose, std::ostream* os) {
  *os << "(" << pose.x << ", " << pose.y << ", " << pose.yaw << ")";
}

}  // namespace enfilade

namespace enfilade::testing {

// EXPECT_THAT(pose, PoseNear(expected, 1e-9, 1e-9)): translation within metres, yaw within radians.
MATCHER_P3(PoseNear, expected, metres, radians, "") {
  const Pose2 error = Between(expected, arg);
  *result_listener << "off by " << error.translation().norm() << " m and " << error.yaw << " rad";
  return error.translation().norm() <= metres && std::abs(error.yaw) <= radians;
}

}  // namespace enfilade::testing
