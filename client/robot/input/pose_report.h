// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/base/time.h"
#include "core/geometry/pose2.h"

namespace enfilade::robot {

// The robot's pose as its own localisation estimates it.
struct PoseReport {
  std::string map;  // id or resource name; or the display name of the map that the server reported last
  PoseWithCovariance T_map_robot;
  TimeNs time = 0;
};

}  // namespace enfilade::robot
