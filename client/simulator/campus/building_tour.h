// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "client/simulator/campus/campus.h"

namespace enfilade::simulator {

// Adds the robot "robot", which visits every area that it can reach from the largest of the lowest level, the nearest
// first, one level after the other by lift, and returns to its start. INVALID_ARGUMENT: there is no room for a robot.
absl::Status PlanTour(Campus& campus);

}  // namespace enfilade::simulator
