// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"

namespace enfilade::perception {

// A grey camera image: 8 bits per pixel, rows from the top without gaps.
struct GreyFrame {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;  // width * height

  friend bool operator==(const GreyFrame&, const GreyFrame&) = default;
};

// A camera image in colour: R, G, B of 8 bits each.
struct ColorFrame {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> samples;  // width * height * 3

  friend bool operator==(const ColorFrame&, const ColorFrame&) = default;
};

// A depth image. 0, NaN and infinities mean "no measurement".
struct DepthFrame {
  int width = 0;
  int height = 0;
  std::vector<float> metres;  // width * height

  friend bool operator==(const DepthFrame&, const DepthFrame&) = default;
};

// INVALID_ARGUMENT: a side is not positive, or the number of samples does not match the size.
absl::Status Validate(const GreyFrame& frame);
absl::Status Validate(const ColorFrame& frame);
absl::Status Validate(const DepthFrame& frame);

}  // namespace enfilade::perception
