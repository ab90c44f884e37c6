// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/areas/map_area.h"
#include "core/grid/map_raster.h"

namespace enfilade::areas {

// Filter masks of Nav2's costmap filters (docs.nav2.org: "Navigating with Keepout Zones", "Navigating with Speed
// Limits"): an occupancy value for each cell, 0 to 100. All are written in mode "raw", where the grey is the value, so
// that each reads back exactly.

// Of the KeepoutFilter (type 0, base 0, multiplier 1).
constexpr std::uint8_t kLethal = 100;
constexpr std::uint8_t kPreferredCost = 0;
constexpr std::uint8_t kCostBesidePreferred = 25;

// kLethal in all cells that a keep-out area has a part of. If there are preferred areas, kPreferredCost in the cells
// whose centres are in one, and kCostBesidePreferred elsewhere; otherwise 0 elsewhere. Other areas do not count.
// `geometry` must be valid.
grid::MapRaster KeepOutMask(const std::vector<MapArea>& areas, const grid::GridGeometry& geometry);

// A speed that the mask cannot say exactly, and the next lower one that it says instead.
struct RoundedSpeed {
  std::string area;  // its display name
  double wanted_mps = 0.0;
  double said_mps = 0.0;
};

// Of the SpeedFilter (type 2, base 0): a cell's value times the multiplier is the speed in m/s; 0 is no limit.
struct SpeedMask {
  grid::MapRaster raster;
  double multiplier = 1.0;
  std::vector<RoundedSpeed> rounded;
};

// The lowest limit in all cells that a speed-limit area has a part of. The multiplier is such that all limits are whole
// multiples of it, if one is; otherwise a hundredth of the highest limit, and limits are rounded down: a lower speed is
// safe. FAILED_PRECONDITION naming the area: its limit is below a hundredth of the highest one, so that no value says
// it.
absl::StatusOr<SpeedMask> MakeSpeedMask(const std::vector<MapArea>& areas, const grid::GridGeometry& geometry);

}  // namespace enfilade::areas
