// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::grid {

// How a grey image is read as a map: the keys of a map's YAML file and whose rules apply to them.
enum class MapMode : std::uint8_t { kTrinary = 0, kScale = 1, kRaw = 2 };
enum class MapDialect : std::uint8_t { kNav2 = 0, kRos1 = 1 };

struct GreyInterpretation {
  MapMode mode = MapMode::kTrinary;
  MapDialect dialect = MapDialect::kNav2;
  bool negate = false;
  double occupied_thresh = 0.65;
  double free_thresh = 0.196;

  friend bool operator==(const GreyInterpretation&, const GreyInterpretation&) = default;
};

// A raster's cells are kept as they came, so that what is not edited goes out as it came in. All are row-major from the
// lower left, as GridGeometry says.

// Made by us: the bytes of an OccupancyGrid.
struct OccupancyCells {
  std::vector<std::uint8_t> values;

  friend bool operator==(const OccupancyCells&, const OccupancyCells&) = default;
};

// From a PGM or PNG file with its YAML.
struct GreyCells {
  std::vector<std::uint8_t> grey{};
  int max_value = 255;                // of white, 1..255
  std::vector<std::uint8_t> alpha{};  // as many as `grey`, 255 = opaque; empty where the image has no transparency
  GreyInterpretation interpretation{};
  // What surrounds the pixels of a binary PGM file, byte for byte; empty where it did not come from one.
  std::string pgm_header{};
  std::string pgm_trailer{};

  friend bool operator==(const GreyCells&, const GreyCells&) = default;
};

// The fields of a JSON map, as they are in the file. m.
struct UnitLimits {
  double xmin = 0.0;
  double xmax = 0.0;
  double ymin = 0.0;
  double ymax = 0.0;
  double stepx = 0.0;
  double stepy = 0.0;
  double level = 0.0;  // how many measurements made a cell 1.0

  friend bool operator==(const UnitLimits&, const UnitLimits&) = default;
};

// From a JSON map: 0 = no obstacle ... 1 = wall; it has no "unknown".
struct UnitCells {
  std::vector<double> values{};
  UnitLimits limits{};

  friend bool operator==(const UnitCells&, const UnitCells&) = default;
};

struct MapRaster {
  GridGeometry geometry;
  std::variant<OccupancyCells, GreyCells, UnitCells> cells;

  friend bool operator==(const MapRaster&, const MapRaster&) = default;
};

// Larger rasters are refused wherever they come from, before memory is asked for.
constexpr std::int64_t kMaxRasterCells = std::int64_t{1} << 28;

// INVALID_ARGUMENT naming the field: a resolution that is not positive and finite, an origin that is not finite, no
// cells, more than kMaxRasterCells.
absl::Status Validate(const GridGeometry& geometry);
// Also that there are as many cells as the geometry says, and a sound interpretation.
absl::Status Validate(const MapRaster& raster);

MapRaster FromOccupancyGrid(OccupancyGrid grid);

// What any raster says about occupancy: a grey one by its interpretation (occupancy_values.h), a JSON one with its
// values as probabilities. `raster` is valid.
OccupancyGrid ToOccupancyGrid(const MapRaster& raster);

}  // namespace enfilade::grid
