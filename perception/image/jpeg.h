// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "core/grid/files/png_codec.h"

namespace enfilade::perception {

enum class JpegColors {
  kGrey,  // 1 channel: the brightness by Rec. 601, as JPEG itself stores it
  kRgb,   // 3 channels; CMYK as Adobe stores it, inverted
};

// Reads a JPEG (ITU T.81, baseline and progressive), turned as its EXIF orientation says (CIPA DC-008, 4.6.4).
// INVALID_ARGUMENT: damaged or truncated, or CMYK that is to become grey. The caller checks the size in the header.
// Thread-safe.
absl::StatusOr<grid::PixelImage> DecodeJpeg(std::string_view bytes, JpegColors colors);

}  // namespace enfilade::perception
