// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "client/simulator/campus/campus.h"

namespace enfilade::simulator {

// Adds the robot "robot", which visits every area that it can reach from the largest of the lowest level, the nearest
// first, one level after the other by lift, and returns to its start. "robot2" begins in the same area, and visits the
// other levels from the highest down, by the last lift that goes there. It is left out if it cannot return.
// INVALID_ARGUMENT: there is no room for a robot.
absl::Status PlanTour(Campus& campus);

}  // namespace enfilade::simulator
