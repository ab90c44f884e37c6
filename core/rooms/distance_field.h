// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/grid/distance_field.h"
#include "core/rooms/ground.h"

namespace enfilade::rooms {

using grid::DistanceField;

// To the nearest obstacle: wall or unknown; not clutter.
DistanceField DistancesToWalls(const GroundMap& ground);

}  // namespace enfilade::rooms
