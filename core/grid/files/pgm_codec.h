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
  // width * height, rows from the BOTTOM as grids count them; the file has them from the top.
  std::vector<std::uint8_t> pixels;
  // P5: all bytes before the pixels and after them (netpbm allows more images to follow; writers add line ends).
  std::string header;
  std::string trailer;
};

// INVALID_ARGUMENT saying what and where: another kind of file; a header that is not digits, promises no pixels or more
// than kMaxRasterCells; fewer pixels than promised (before anything is allocated); 16 bits (max_value above 255), which
// a map of 8 bits would not give back; a pixel above max_value; a header or trailer of more than 64 KiB.
absl::StatusOr<PgmImage> DecodePgm(std::string_view bytes);

// How a P5 file is written.
struct PgmFrame {
  int width = 0;
  int height = 0;
  int max_value = 255;
  // From DecodePgm. Taken as they are where the header fits the size and max_value, so that a file comes back byte for
  // byte; else a plain header is written.
  std::string_view header;
  std::string_view trailer;
};

// `pixels`: as many as the frame says, rows from the bottom.
std::string EncodePgm(const PgmFrame& frame, std::span<const std::uint8_t> pixels);

}  // namespace enfilade::grid
