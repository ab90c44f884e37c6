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

// Map files for exchange with other programs; docs/map_files.md describes the formats.
enum class MapFileFormat : std::uint8_t { kPgm = 0, kPng = 1, kJson = 2 };

struct MapFile {
  std::string name;  // without a folder
  std::string bytes;
};

struct MapFileOptions {
  MapFileFormat format = MapFileFormat::kPgm;
  // How cells from other sources than images become greys.
  GreySaveOptions save{};
  // For rasters from other sources than JSON maps.
  double json_level = 10.0;
};

// NAME.pgm or NAME.png, each with NAME.yaml; or NAME.json. NAME is SafeStem(name). A raster exported in the
// format in which it was imported is unchanged: a PGM's bytes, a JSON map's numbers, a PNG's greys, with the imported
// thresholds and mode. INVALID_ARGUMENT: the raster is invalid, or the format cannot hold it: unknown cells in mode
// "scale" as PGM (no transparency), a rotated map as JSON.
absl::StatusOr<std::vector<MapFile>> RenderFiles(const MapRaster& raster, std::string_view name,
                                                 const MapFileOptions& options);

struct ImportedMap {
  MapRaster raster;
  MapFileFormat format = MapFileFormat::kPgm;
  std::vector<std::string> warnings;  // what was ignored or changed, human-readable
};

// One .json file; or one .yaml (.yml) file and the PGM or PNG image that it names (folders in the name are ignored).
// INVALID_ARGUMENT names the file and its fault.
absl::StatusOr<ImportedMap> ImportFiles(std::span<const MapFile> files, MapDialect dialect);

// The image that a map's YAML file names, verbatim: relative to the YAML file, or absolute.
absl::StatusOr<std::string> ImageNameOf(std::string_view yaml);

// A file name for a map of any display name: ASCII letters, digits, '.', '_' and '-' are kept, any other run becomes
// one
// '-'; no '.' or '-' at either end; at most 64 characters; "map" if nothing is left.
std::string SafeStem(std::string_view name);

}  // namespace enfilade::grid
