// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "core/rooms/ground.h"

namespace enfilade::rooms {

// The narrow places of the open ground: the saddles of the distance to the walls, at which two basins of a watershed
// meet (L. Najman, M. Schmitt, "Watershed of a continuous function", 1994). Two basins are one unless both are wider
// than the place by `narrowing` cells on each side; nothing above `max_radius` is narrow. Each is the cell of the
// greatest distance on a border between two basins; two basins can share several borders.
struct NarrowPlaces {
  double narrowing = 2.0;
  double max_radius = 26.0;
};
std::vector<std::size_t> FindNarrowPlaces(const GroundMap& ground, const DistanceField& field,
                                          const NarrowPlaces& limits);

}  // namespace enfilade::rooms
