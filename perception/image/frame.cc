// SPDX-License-Identifier: Apache-2.0
#include "perception/image/frame.h"

#include <cstddef>

#include "core/base/error.h"

namespace enfilade::perception {
namespace {

absl::Status ValidateSize(int width, int height, std::size_t channels, std::size_t samples) {
  if (width <= 0 || height <= 0)
    return InvalidArgument("image of {}x{} pixels: both sides must be positive", width, height);
  const std::size_t expected = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * channels;
  if (samples != expected) {
    return InvalidArgument("image of {}x{} pixels has {} samples: expected {}", width, height, samples, expected);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Validate(const GreyFrame& frame) {
  return ValidateSize(frame.width, frame.height, 1, frame.pixels.size());
}
absl::Status Validate(const ColorFrame& frame) {
  return ValidateSize(frame.width, frame.height, 3, frame.samples.size());
}
absl::Status Validate(const DepthFrame& frame) {
  return ValidateSize(frame.width, frame.height, 1, frame.metres.size());
}

}  // namespace enfilade::perception
