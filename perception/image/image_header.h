// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"

namespace enfilade::perception {

enum class ImageFormat { kPng, kJpeg };

// The header of an encoded image.
struct ImageHeader {
  ImageFormat format = ImageFormat::kPng;
  std::int64_t width = 0;
  std::int64_t height = 0;
  int components = 0;  // 1 grey, 2 grey + alpha, 3 colour, 4 colour + alpha (PNG) or CMYK (JPEG)
  int bit_depth = 0;   // of one sample
};

// Reads a PNG's IHDR (RFC 2083, 4.1.1) or a JPEG's first frame header (ITU T.81, B.2.2). INVALID_ARGUMENT: another
// format, a truncated or inconsistent header. Reads nothing but the header.
absl::StatusOr<ImageHeader> ReadImageHeader(std::string_view bytes);

}  // namespace enfilade::perception
