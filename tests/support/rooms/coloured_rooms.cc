// SPDX-License-Identifier: Apache-2.0
#include "tests/support/rooms/coloured_rooms.h"

#include <map>
#include <string>

#include "absl/status/status.h"
#include "core/base/status_macros.h"
#include "core/grid/files/png_codec.h"
#include "io/file.h"

namespace enfilade::testing {

absl::StatusOr<ColouredRooms> ReadColouredRooms(const std::filesystem::path& picture) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(picture));
  ENFILADE_ASSIGN_OR_RETURN(const grid::PixelImage image, grid::DecodePng(bytes));
  if (image.channels < 3) return absl::InvalidArgumentError(picture.string() + " has no colours");
  ColouredRooms coloured;
  coloured.geometry.width = image.width;
  coloured.geometry.height = image.height;
  coloured.rooms.resize(coloured.geometry.cell_count());
  coloured.colours = {{0, 0, 0}};
  std::map<std::array<std::uint8_t, 3>, int> room_of{{{0, 0, 0}, 0}};
  const std::uint8_t* sample = image.samples.data();
  for (int row = image.height - 1; row >= 0; --row) {
    for (int column = 0; column < image.width; ++column, sample += image.channels) {
      const std::array<std::uint8_t, 3> colour{sample[0], sample[1], sample[2]};
      const auto [known, is_new] = room_of.try_emplace(colour, static_cast<int>(room_of.size()));
      if (is_new) coloured.colours.push_back(colour);
      coloured.rooms[coloured.geometry.index(column, row)] = known->second;
    }
  }
  return coloured;
}

}  // namespace enfilade::testing
