// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "core/grid/occupancy_grid.h"

namespace enfilade::grid {

// How a grey image is read as a map: the keys of its YAML file, and the dialect whose rules apply.
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

// Cells are kept in the form in which they were imported, so an unedited map is exported unchanged. All are row-major
// from the lower left, as in GridGeometry.

// Of a map made by this program: the cells of an OccupancyGrid.
struct OccupancyCells {
  std::vector<std::uint8_t> values;

  friend bool operator==(const OccupancyCells&, const OccupancyCells&) = default;
};

// From a PGM or PNG file with its YAML.
struct GreyCells {
  std::vector<std::uint8_t> grey{};
  int max_value = 255;                // of white, 1..255
  std::vector<std::uint8_t> alpha{};  // as many as `grey`, 255 = opaque; empty if the image has no transparency
  GreyInterpretation interpretation{};
  // The bytes before and after the pixels of a binary PGM file; empty for other sources.
  std::string pgm_header{};
  std::string pgm_trailer{};

  friend bool operator==(const GreyCells&, const GreyCells&) = default;
};

// The fields of a JSON map as in the file, in m.
struct UnitLimits {
  double xmin = 0.0;
  double xmax = 0.0;
  double ymin = 0.0;
  double ymax = 0.0;
  double stepx = 0.0;
  double stepy = 0.0;
  double level = 0.0;  // the number of measurements that made a cell 1.0

  friend bool operator==(const UnitLimits&, const UnitLimits&) = default;
};

// From a JSON map: 0 = no obstacle ... 1 = wall. The format has no "unknown".
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

// Larger rasters from any source are refused before memory is allocated.
constexpr std::int64_t kMaxRasterCells = std::int64_t{1} << 28;

// INVALID_ARGUMENT naming the field: a resolution that is not positive and finite, an origin that is not finite, no
// cells, more than kMaxRasterCells.
absl::Status Validate(const GridGeometry& geometry);
// Also checks that the number of cells matches the geometry and that the interpretation is valid.
absl::Status Validate(const MapRaster& raster);

MapRaster FromOccupancyGrid(OccupancyGrid grid);

// The occupancy of any raster: grey cells by their interpretation (occupancy_values.h), JSON values as probabilities.
// `raster` must be valid.
OccupancyGrid ToOccupancyGrid(const MapRaster& raster);

}  // namespace enfilade::grid
