// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/base/time.h"
#include "core/geometry/pose2.h"

namespace enfilade::robot {

// Where the robot is by a localisation of its own.
struct OwnPose {
  std::string map;  // its id or resource name, or the display name of the map that the server has told last
  PoseWithCovariance T_map_robot;
  TimeNs time = 0;
};

}  // namespace enfilade::robot
