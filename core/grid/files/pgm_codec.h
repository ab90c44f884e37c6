// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace enfilade::grid {

// Netpbm's grey images (netpbm.sourceforge.net/doc/pgm.html): binary P5 and plain P2, of up to 8 bits, with comments.
struct PgmImage {
  int width = 0;
  int height = 0;
  int max_value = 255;  // of white
  // width * height, rows from the BOTTOM as in grids; the file has them from the top.
  std::vector<std::uint8_t> pixels;
  // P5: the bytes before and after the pixels (netpbm allows more images to follow; some writers add line ends).
  std::string header;
  std::string trailer;
};

// INVALID_ARGUMENT naming the fault and its position: another kind of file; a header that is not digits or announces no
// pixels or more than kMaxRasterCells; fewer pixels than announced (checked before anything is allocated); 16 bits
// (max_value above 255), which 8 bits cannot restore; a pixel above max_value; a header or trailer above 64 KiB.
absl::StatusOr<PgmImage> DecodePgm(std::string_view bytes);

// How a P5 file is written.
struct PgmFrame {
  int width = 0;
  int height = 0;
  int max_value = 255;
  // From DecodePgm. Written unchanged if the header matches the size and max_value, so that a file is restored byte for
  // byte; otherwise a plain header is written.
  std::string_view header;
  std::string_view trailer;
};

// `pixels`: width * height, rows from the bottom.
std::string EncodePgm(const PgmFrame& frame, std::span<const std::uint8_t> pixels);

}  // namespace enfilade::grid
