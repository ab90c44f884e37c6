// SPDX-License-Identifier: Apache-2.0
// The YAML file of a map, and its import together with an image.
#include "core/grid/files/map_files.h"
#include "core/grid/files/map_yaml.h"
#include "tests/fuzz/decoder.h"

namespace enfilade::fuzz {

std::vector<std::string> Seeds() {
  return {
      "image: map.pgm\nmode: trinary\nresolution: 0.05\norigin: [-1, 2.5, 0.3]\nnegate: 0\noccupied_thresh: 0.65\n"
      "free_thresh: 0.196\n",
      "{image: \"map.pgm\", resolution: 1e-1, origin: [0, 0, 0], negate: true, occupied_thresh: 0.1, free_thresh: "
      "0.9, mode: scale, other: &a [1, *a]}"};
}

bool Decode(std::string_view bytes) {
  (void)grid::ImageNameOf(bytes);
  bool accepted = true;
  const std::vector<grid::MapFile> files = {{"map.yaml", std::string(bytes)}, {"map.pgm", "P5 2 2 255\nabcd"}};
  for (const grid::MapDialect dialect : {grid::MapDialect::kNav2, grid::MapDialect::kRos1}) {
    const auto map = grid::ParseMapYaml(bytes, dialect);
    accepted = accepted && map.ok();
    if (map.ok()) {
      Expect(map->yaml.resolution > 0.0 && IsFinite(map->yaml.origin) && !map->yaml.image.empty(),
             "a map has a resolution, an origin and an image");
    }
    const auto imported = grid::ImportFiles(files, dialect);
    if (!imported.ok()) continue;
    Expect(grid::Validate(imported->raster).ok(), "an imported map is valid");
    (void)grid::ToOccupancyGrid(imported->raster);
  }
  return accepted;
}

}  // namespace enfilade::fuzz
