// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/offline/rooms_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/grid/files/png_codec.h"
#include "core/grid/files/rgb_image.h"

namespace enfilade::cli {
namespace {

// Neighbouring numbers get colours far apart: the hue turns by the golden angle.
grid::Rgb RoomColor(int id) {
  const double hue = std::fmod(id * 137.508, 360.0) / 60.0;
  const double low = id % 2 == 0 ? 120.0 : 160.0;
  const double part = std::fmod(hue, 2.0) - 1.0;
  const double middle = low + (250.0 - low) * (1.0 - std::abs(part));
  constexpr int kOrder[6][3] = {{2, 1, 0}, {1, 2, 0}, {0, 2, 1}, {0, 1, 2}, {1, 0, 2}, {2, 0, 1}};
  const std::array<double, 3> levels{low, middle, 250.0};
  grid::Rgb color{};
  for (std::size_t i = 0; i < 3; ++i) {
    const int level = kOrder[static_cast<int>(hue) % 6][i];
    color[i] = static_cast<std::uint8_t>(levels[static_cast<std::size_t>(level)]);
  }
  return color;
}

}  // namespace

absl::StatusOr<std::string> EncodeLabels(const rooms::RoomPartition& partition) {
  const bool wide = partition.rooms.size() > 255;
  const std::size_t bytes_per_label = wide ? 2 : 1;
  const auto row_bytes = static_cast<std::ptrdiff_t>(bytes_per_label) * partition.geometry.width;
  std::vector<std::uint8_t> bytes;
  bytes.reserve(partition.labels.size() * bytes_per_label);
  for (const std::uint16_t label : partition.labels) {
    if (wide) bytes.push_back(static_cast<std::uint8_t>(label >> 8));
    bytes.push_back(static_cast<std::uint8_t>(label & 0xFF));
  }
  return grid::EncodePng(grid::PixelRows{.width = partition.geometry.width,
                                         .height = partition.geometry.height,
                                         .channels = 1,
                                         .top_row = bytes.data() + row_bytes * (partition.geometry.height - 1),
                                         .stride = -row_bytes,
                                         .bit_depth = wide ? 16 : 8});
}

grid::RgbImage DrawRooms(const grid::OccupancyGrid& grid, const rooms::RoomPartition& partition) {
  grid::RgbImage image = grid::DrawGrid(grid);
  const grid::GridGeometry& geometry = partition.geometry;
  for (int row = 0; row < geometry.height; ++row) {
    for (int column = 0; column < geometry.width; ++column) {
      const std::uint16_t label = partition.labels[geometry.index(column, row)];
      if (label == 0) continue;
      const grid::Rgb color = RoomColor(label);
      std::uint8_t* const pixel = image.samples.data() + 3 * geometry.index(column, geometry.height - 1 - row);
      // Darker where the map is, so that what stands in the room can be seen.
      for (std::size_t i = 0; i < 3; ++i)
        pixel[i] = static_cast<std::uint8_t>(color[i] * (64 + pixel[i] * 3 / 4) / 256);
    }
  }
  for (const rooms::Door& door : partition.doors) {
    grid::DrawLine(image, grid::PixelOf(geometry, door.a), grid::PixelOf(geometry, door.b), grid::kRed, 2);
  }
  return image;
}

}  // namespace enfilade::cli
