// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/json_map.h"
#include "tests/fuzz/decoder.h"

namespace enfilade::fuzz {

std::vector<std::string> Seeds() {
  return {R"({"xmin": 0, "xmax": 2, "ymin": 0, "ymax": 1, "stepx": 1, "stepy": 1, "level": 10,)"
          R"( "data": [0, 0.5, 1, 1, 0.25, 0]})",
          R"({"xmin": -1.5, "xmax": 0.5, "ymin": 0, "ymax": 1, "stepx": 0.5, "stepy": 0.5, "Level": 3, "more": {"a":)"
          R"( [true, null, "\u00e9"]}, "data": [0, 1, 0, 1, 0, 1, 0, 1]})"};
}

bool Decode(std::string_view bytes) {
  const auto map = grid::ParseJsonMap(bytes);
  if (!map.ok()) return false;
  Expect(grid::Validate(map->raster).ok(), "a JSON map is valid");
  const auto& cells = std::get<grid::UnitCells>(map->raster.cells);
  const auto same = grid::ParseJsonMap(grid::FormatJsonMap(cells.limits, cells.values));
  Expect(same.ok() && same->raster == map->raster, "a JSON map is read back");
  return true;
}

}  // namespace enfilade::fuzz
