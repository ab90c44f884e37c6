// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::testing {

// A picture in which each room has a colour of its own, and black is all else.
struct ColouredRooms {
  grid::GridGeometry geometry;                       // of the pixels, the lowest row first; the resolution is not known
  std::vector<int> rooms;                            // of each pixel, from 1; 0: none
  std::vector<std::array<std::uint8_t, 3>> colours;  // of each room; the first is black
};

// Errors as io::ReadFile's and grid::DecodePng's; INVALID_ARGUMENT if the picture has no colours.
absl::StatusOr<ColouredRooms> ReadColouredRooms(const std::filesystem::path& picture);

}  // namespace enfilade::testing
