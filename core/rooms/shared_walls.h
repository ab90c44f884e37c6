// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>

#include "core/rooms/ground.h"
#include "core/rooms/region_map.h"

namespace enfilade::rooms {

// How long the walls are that part each two regions: of what is not open between them and no thicker than 0.5 m. A door
// is in a wall that goes on beside it, on the other side of which is the other room; a box has the room on both sides.
class SharedWalls {
 public:
  SharedWalls(const GroundMap& ground, const RegionMap& map);

  // m
  double Between(std::int32_t one, std::int32_t other) const;
  // m, of the walls that part one of `some` from one of `others`.
  double Between(std::span<const std::int32_t> some, std::span<const std::int32_t> others) const;

 private:
  // Rows and columns in which a wall was crossed.
  struct Crossings {
    double rows = 0.0;
    double columns = 0.0;
  };

  Crossings At(std::int32_t one, std::int32_t other) const;

  double resolution_;
  std::map<std::pair<std::int32_t, std::int32_t>, Crossings> crossings_;  // the lower region first
};

}  // namespace enfilade::rooms
