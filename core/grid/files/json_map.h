// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/map_raster.h"

namespace enfilade::grid {

// Maps as one JSON object: xmin, xmax, ymin, ymax, stepx, stepy (m), level, and data, all cells from 0 (no obstacle) to
// 1 (wall) in one array. Format: A. Mabire, "Making and editing a cartography", 2023.
//
// What that work leaves open is read so:
// * Rows are y, columns x; the first number is the cell at (xmin, ymin) and rows go up, as its code fills them.
// * With (xmax - xmin) / stepx + 1 columns the limits are the centres of the outer cells (401 for 6 m at 0.015 m: that
//   work's maps); with one less they are the outer edges. Likewise rows; both axes the same way. `data` decides.
// * Cells are square: stepx and stepy must be equal.
// * "level" may also be spelled "Level".
struct ParsedJsonMap {
  MapRaster raster;                   // UnitCells
  std::vector<std::string> warnings;  // unknown keys, which are ignored
};

// INVALID_ARGUMENT naming the field (and the line or the index in `data`): not JSON; a field missing, twice or of
// another type; numbers that do not fit together; too few or too many data; data outside [0, 1]; beyond
// kMaxRasterCells.
absl::StatusOr<ParsedJsonMap> ParseJsonMap(std::string_view text);

// Limits for a raster that did not come from such a file: those of the cells' centres. INVALID_ARGUMENT where the
// raster is rotated, which the format cannot say.
absl::StatusOr<UnitLimits> UnitLimitsOf(const GridGeometry& geometry, double level);

// Every number with the fewest digits that give the same double when read back.
std::string FormatJsonMap(const UnitLimits& limits, std::span<const double> values);
// The same of a grid: the cells' probabilities to 4 decimals, which are enough to come back to the same bytes; unknown
// cells, for which the format has no value, as 0.5.
std::string FormatJsonMap(const UnitLimits& limits, std::span<const std::uint8_t> cells);

}  // namespace enfilade::grid
