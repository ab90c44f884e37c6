// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"
#include "perception/image/frame.h"

namespace enfilade::perception {

struct DecodeLimits {
  // Checked against the header, before memory is allocated. No robot's camera has as many as 25 Mpx.
  std::int64_t max_pixels = 25'000'000;
};

// Brightness by Rec. 601 (0.299 R + 0.587 G + 0.114 B), for any channel order in the file; transparency is ignored. PNG
// (8 or 16 bits, palettes) and JPEG. INVALID_ARGUMENT: another format, damaged or truncated data, more pixels than the
// limit, CMYK. Thread-safe.
absl::StatusOr<GreyFrame> DecodeGrey(std::string_view bytes, const DecodeLimits& limits = {});
absl::StatusOr<ColorFrame> DecodeColor(std::string_view bytes, const DecodeLimits& limits = {});

// A depth image as sent by robots (ImageEncoding::kDepthPng16): a PNG with one 16-bit channel in units of
// `metres_per_unit`; 0 means "no measurement". INVALID_ARGUMENT as above, and for any other kind of PNG.
absl::StatusOr<DepthFrame> DecodeDepth(std::string_view bytes, double metres_per_unit = 0.001,
                                       const DecodeLimits& limits = {});

}  // namespace enfilade::perception
