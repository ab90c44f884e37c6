// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/map_raster.h"
#include "core/grid/occupancy_values.h"

namespace enfilade::grid {

// A PNG image as the grey cells of a raster.
struct GreyImage {
  int width = 0;
  int height = 0;
  GreyCells cells;  // without interpretation
  std::vector<std::string> warnings;
};

// Reads a PNG; errors as ReadPng. Colours become grey: for nav2 by Rec. 601 luma in GraphicsMagick's integers, (306 R +
// 601 G + 117 B) / 1024 rounded; for ros1 the rounded mean of R, G and B. The alpha channel is kept if any pixel is not
// opaque; for ros1, whose rules use opaque alphas too, always.
absl::StatusOr<GreyImage> DecodeGreyPng(std::string_view png, MapDialect dialect);

// Writes grey cells as a PNG: one channel, or RGB + alpha if there are alphas (Nav2's image library fails on grey with
// alpha). `width` and `height` are those of the raster.
absl::StatusOr<std::string> EncodeGreyPng(const GreyCells& cells, int width, int height);

// A grid as saved by Nav2 (SavedGrey). Has alphas only if a cell is transparent.
GreyCells SaveAsGrey(const std::vector<std::uint8_t>& occupancy, const GreySaveOptions& options);

}  // namespace enfilade::grid
