// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace enfilade::graph {

// The kind of place that joins maps. The numbers are in the database and on robots' disks: never reuse one.
enum class LinkPointKind : std::int16_t { kDoor = 1, kLift = 2, kStairs = 3, kRamp = 4, kOpening = 5 };

}  // namespace enfilade::graph
