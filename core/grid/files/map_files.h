// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/map_raster.h"
#include "core/grid/occupancy_values.h"

namespace enfilade::grid {

// Maps as people's files; which say what, see docs/map_files.md.
enum class MapFileFormat : std::uint8_t { kPgm = 0, kPng = 1, kJson = 2 };

struct MapFile {
  std::string name;  // without a folder
  std::string bytes;
};

struct MapFileOptions {
  MapFileFormat format = MapFileFormat::kPgm;
  // How cells that did not come from an image become greys.
  GreySaveOptions save{};
  // For rasters that did not come from a JSON map.
  double json_level = 10.0;
};

// NAME.pgm or NAME.png, each with NAME.yaml; or NAME.json. NAME is SafeStem(name). A raster goes out in the format in
// which it came as it came: a PGM's bytes, a JSON's numbers, a PNG's greys, with the thresholds and mode that it came
// with. INVALID_ARGUMENT where the raster is not valid, or where a format cannot hold it: unknown cells in mode "scale"
// as PGM (it has no transparency), a rotated map as JSON.
absl::StatusOr<std::vector<MapFile>> RenderFiles(const MapRaster& raster, std::string_view name,
                                                 const MapFileOptions& options);

struct ImportedMap {
  MapRaster raster;
  MapFileFormat format = MapFileFormat::kPgm;
  std::vector<std::string> warnings;  // in words: what was ignored or changed on the way
};

// One .json file; or one .yaml (.yml) file and the PGM or PNG image that it names (folders in that name do not count).
// INVALID_ARGUMENT naming the file and what is wrong with it.
absl::StatusOr<ImportedMap> ImportFiles(std::span<const MapFile> files, MapDialect dialect);

// The image that a map's YAML file names, as it is written there: relative to the YAML file, or absolute.
absl::StatusOr<std::string> ImageNameOf(std::string_view yaml);

// A file name for a map that people gave any name: ASCII letters, digits, '.', '_' and '-' as they are, runs of all
// else as one '-'; no '.' or '-' at either end; at most 64 characters; "map" where nothing is left.
std::string SafeStem(std::string_view name);

}  // namespace enfilade::grid
