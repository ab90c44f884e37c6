// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "client/simulator/campus/campus.h"

namespace enfilade::simulator {

// A building generated from a seed, of another kind than RandomBuilding: a corridor with suites on both sides and a
// hall at its end. A suite has a bathroom beside its entrance or a store in a far corner. Half of all doors stand at
// the end of their wall: one jamb is the room's own wall. What looks like a door but is none: the mouth of the passage
// past a bathroom, alcoves, partitions that end before the opposite wall, rows of shelves, pillars in the corridor. The
// robot "robot" visits every area and returns to its start (PlanTour). The same seed gives the same building.
// INVALID_ARGUMENT: there is no room for a robot.
absl::StatusOr<Campus> RandomSuites(std::uint64_t seed);

}  // namespace enfilade::simulator
