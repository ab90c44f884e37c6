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
// Where that work is ambiguous:
// * Rows are y, columns x; the first number is the cell at (xmin, ymin) and rows go up, as its code fills them.
// * With (xmax - xmin) / stepx + 1 columns the limits are the centres of the outer cells (that work's maps: 401 for 6 m
//   at 0.015 m); with one less they are the outer edges. The same for rows; both axes alike. The size of `data`
//   decides.
// * Cells are square: stepx and stepy must be equal.
// * "level" may also be spelled "Level".
struct ParsedJsonMap {
  MapRaster raster;                   // UnitCells
  std::vector<std::string> warnings;  // unknown keys, which are ignored
};

// INVALID_ARGUMENT naming the field (and the line or the index in `data`): not JSON; a field missing, given twice or of
// another type; inconsistent numbers; too few or too many data; data outside [0, 1]; more than kMaxRasterCells.
absl::StatusOr<ParsedJsonMap> ParseJsonMap(std::string_view text);

// Limits for a raster from another source: the centres of the outer cells. INVALID_ARGUMENT: the raster is rotated,
// which the format cannot express.
absl::StatusOr<UnitLimits> UnitLimitsOf(const GridGeometry& geometry, double level);

// Writes each number with the fewest digits that read back as the same double.
std::string FormatJsonMap(const UnitLimits& limits, std::span<const double> values);
// The same for a grid: probabilities with 4 decimals, enough to restore the same bytes. Unknown cells, for which the
// format has no value, become 0.5.
std::string FormatJsonMap(const UnitLimits& limits, std::span<const std::uint8_t> cells);

}  // namespace enfilade::grid
