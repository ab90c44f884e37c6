// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/pose2.h"

namespace enfilade::prior {

// One look of the robot.
struct PlanLook {
  Pose2 T_map_robot;                  // by SLAM; only the motion from look to look counts
  std::vector<Eigen::Vector2d> hits;  // ends of beams, in the robot's frame, m
};

}  // namespace enfilade::prior
