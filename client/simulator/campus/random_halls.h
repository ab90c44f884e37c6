// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "client/simulator/campus/campus.h"

namespace enfilade::simulator {

// A building generated from a seed, of another kind than RandomBuilding and RandomSuites: an open-plan hall with rooms
// around it. In the hall stand what divides it and what makes no room of it: free-standing walls, walls that reach into
// it, some with a hook, booths that are open on one side, pillars and rows of desks. Kiosks are rooms of their own that
// stand in it; from some a wall goes on. Around every free-standing part there is a way of at least a metre, and no
// wall that reaches into the hall leaves less than 1.8 m to what it points at. The robot "robot" visits every area and
// returns to its start (PlanTour). The same seed gives the same building. INVALID_ARGUMENT: there is no room for a
// robot.
absl::StatusOr<Campus> RandomHalls(std::uint64_t seed);

}  // namespace enfilade::simulator
