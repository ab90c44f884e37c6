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

// An image of 8-bit samples (SixteenBits::kKept: of 16 bits): 1 channel grey, 2 grey + alpha, 3 RGB, 4 RGB + alpha;
// rows from the top.
struct PixelImage {
  int width = 0;
  int height = 0;
  int channels = 1;
  std::vector<std::uint8_t> samples;  // width * height * channels; twice as many of 16 bits

  friend bool operator==(const PixelImage&, const PixelImage&) = default;
};

// A view of such an image's rows. A negative stride suits a raster whose first row is the lowest.
struct PixelRows {
  int width = 0;
  int height = 0;
  int channels = 1;
  const std::uint8_t* top_row = nullptr;
  std::ptrdiff_t stride = 0;  // from a row to the one below, in bytes
  int bit_depth = 8;          // 8; 16: each sample is two bytes, the higher first
};

// Receives an image row by row, so that the pixels are not held in memory twice.
class PixelReceiver {
 public:
  virtual ~PixelReceiver() = default;
  // Called before the first row. `channels` as in PixelImage.
  virtual void Begin(int width, int height, int channels) = 0;
  // Called once for each row, from the top.
  virtual void Row(int row, const std::uint8_t* samples) = 0;
};

// Larger images are refused before memory is allocated; so are files too short to hold the announced pixels at any
// compression.
constexpr std::int64_t kMaxImagePixels = std::int64_t{1} << 28;

// What becomes of samples of 16 bits.
enum class SixteenBits {
  kRefused,  // 8 bits cannot restore them
  kScaled,   // to 8 bits, rounded
  kKept,     // each sample is two bytes, the higher first; other depths are refused
};

// Reads a PNG. Palettes and 1, 2 and 4 bits become 8 bits, a transparent colour becomes an alpha channel, samples are
// taken as stored (no gamma). INVALID_ARGUMENT, with libpng's message, on damaged data; on samples of 16 bits, unless
// `sixteen_bits` says otherwise; on more than kMaxImagePixels. Bytes after the end of the image are ignored. Interlaced
// images need memory for a second copy of the image.
absl::Status ReadPng(std::string_view png, PixelReceiver& receiver, SixteenBits sixteen_bits = SixteenBits::kRefused);
absl::StatusOr<PixelImage> DecodePng(std::string_view png, SixteenBits sixteen_bits = SixteenBits::kRefused);

// Writes a PNG; the same rows give the same bytes. INVALID_ARGUMENT: a side is not positive or above 1,000,000,
// or another number of channels or bits.
absl::StatusOr<std::string> EncodePng(const PixelRows& rows);
absl::StatusOr<std::string> EncodePng(const PixelImage& image);

}  // namespace enfilade::grid
