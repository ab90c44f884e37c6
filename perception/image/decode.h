// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"
#include "perception/image/frame.h"

namespace enfilade::perception {

struct DecodeLimits {
  // Checked against the header, before memory is asked for. 25 Mpx is beyond any robot's camera.
  std::int64_t max_pixels = 25'000'000;
};

// Brightness by Rec. 601 (0.299 R + 0.587 G + 0.114 B), whatever the order of the channels in the file; transparency is
// ignored. PNG (8 or 16 bits, palettes) and JPEG. INVALID_ARGUMENT: neither of the two, damaged or cut short, more
// pixels than the limit, CMYK. Thread-safe.
absl::StatusOr<GreyFrame> DecodeGrey(std::string_view bytes, const DecodeLimits& limits = {});
absl::StatusOr<ColorFrame> DecodeColor(std::string_view bytes, const DecodeLimits& limits = {});

// A depth image as robots send it (ImageEncoding::kDepthPng16): PNG of one 16-bit channel, `metres_per_unit` each; 0 is
// "nothing measured". INVALID_ARGUMENT as above, and for any other kind of PNG.
absl::StatusOr<DepthFrame> DecodeDepth(std::string_view bytes, double metres_per_unit = 0.001,
                                       const DecodeLimits& limits = {});

// Pixels as drivers deliver them, named as in ROS' sensor_msgs.
enum class PixelOrder { kMono8, kBgr8, kRgb8, kBgra8, kRgba8 };

struct RawImage {
  int width = 0;
  int height = 0;
  std::int64_t step = 0;  // bytes from a row to the next; 0: rows without gaps
  PixelOrder order = PixelOrder::kMono8;
  std::string_view bytes;
};

// INVALID_ARGUMENT: sides that are not positive, a step shorter than a row, fewer bytes than rows, too many pixels.
absl::StatusOr<GreyFrame> GreyFromRaw(const RawImage& image, const DecodeLimits& limits = {});
GreyFrame GreyFromColor(const ColorFrame& frame);

}  // namespace enfilade::perception
