// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "client/simulator/campus/floor_areas.h"

namespace enfilade::simulator {

// Doorways that a drawing shows only as gaps: where a wall ends freely and, 0.6 to 1.8 m ahead in its direction,
// another wall begins or crosses. Ends of walls at one of the `doors` are not free.
std::vector<Barrier> GapsBetween(const std::vector<Barrier>& walls, const std::vector<Barrier>& doors);

}  // namespace enfilade::simulator
