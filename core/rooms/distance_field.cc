// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/distance_field.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace enfilade::rooms {

DistanceField DistancesToWalls(const GroundMap& ground) {
  std::vector<std::uint8_t> obstacles(ground.cells.size());
  for (std::size_t i = 0; i < obstacles.size(); ++i) obstacles[i] = ground.IsOpen(i) ? 0 : 1;
  return grid::DistancesTo(obstacles, ground.width, ground.height);
}

}  // namespace enfilade::rooms
