// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/map_raster.h"
#include "core/grid/occupancy_values.h"

namespace enfilade::grid {

// Between PNG images and a raster's grey cells.
struct GreyImage {
  int width = 0;
  int height = 0;
  GreyCells cells;  // no interpretation yet
  std::vector<std::string> warnings;
};

// Reads a PNG; errors as ReadPng. Colours become grey: for nav2 by Rec. 601 luma in GraphicsMagick's integers, (306 R +
// 601 G + 117 B) / 1024 rounded; for ros1 the mean of R, G and B, rounded. Alphas are kept where a pixel is not opaque,
// and for ros1, which reckons with opaque ones too, wherever the image has the channel.
absl::StatusOr<GreyImage> DecodeGreyPng(std::string_view png, MapDialect dialect);

// Grey cells as the image that they would be saved as: one channel, or RGB + alpha where there are alphas (Nav2's image
// library fails on grey with alpha). `width` and `height` are those of the cells' raster.
absl::StatusOr<std::string> EncodeGreyPng(const GreyCells& cells, int width, int height);

// A grid as Nav2 would save it (SavedGrey). Alphas only where a cell is transparent.
GreyCells SaveAsGrey(const std::vector<std::uint8_t>& occupancy, const GreySaveOptions& options);

}  // namespace enfilade::grid
