// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace enfilade::grid {

// An image of 8-bit samples: 1 channel grey, 2 grey + alpha, 3 RGB, 4 RGB + alpha; rows from the top.
struct PixelImage {
  int width = 0;
  int height = 0;
  int channels = 1;
  std::vector<std::uint8_t> samples;  // width * height * channels

  friend bool operator==(const PixelImage&, const PixelImage&) = default;
};

// Rows of such an image that lie elsewhere. A negative stride walks a raster whose first row is the lowest.
struct PixelRows {
  int width = 0;
  int height = 0;
  int channels = 1;
  const std::uint8_t* top_row = nullptr;
  std::ptrdiff_t stride = 0;  // from a row to the one below, in samples
};

// Takes an image row by row, so that the pixels need not be in memory in the file's form and in the caller's at once.
class PixelReceiver {
 public:
  virtual ~PixelReceiver() = default;
  // Before the first row. `channels` as in PixelImage.
  virtual void Begin(int width, int height, int channels) = 0;
  // Rows from the top, each once, in order.
  virtual void Row(int row, const std::uint8_t* samples) = 0;
};

// Images of more pixels are refused before their memory is asked for; so are those whose file is too short to hold
// them however well packed.
constexpr std::int64_t kMaxImagePixels = std::int64_t{1} << 28;

// Reads a PNG. Palettes and 1, 2 and 4 bits become 8 bits, a transparent colour becomes an alpha channel, samples are
// taken as they are stored (no gamma). INVALID_ARGUMENT, with libpng's words, on anything damaged; on 16-bit samples,
// which 8 bits would not give back; on more than kMaxImagePixels. Bytes after the image's end are ignored. Interlaced
// images take the whole image's memory besides the receiver's.
absl::Status ReadPng(std::string_view png, PixelReceiver& receiver);
absl::StatusOr<PixelImage> DecodePng(std::string_view png);

// Writes a PNG; the same rows give the same bytes. INVALID_ARGUMENT where a side is not positive or above 1,000,000.
absl::StatusOr<std::string> EncodePng(const PixelRows& rows);
absl::StatusOr<std::string> EncodePng(const PixelImage& image);

}  // namespace enfilade::grid
