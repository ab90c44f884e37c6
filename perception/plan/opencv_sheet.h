// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string_view>

#include "absl/status/statusor.h"

namespace enfilade::perception {

// The picture of a plan, turned as people see it.
struct Sheet {
  cv::Mat brightness;  // 8-bit grey, transparent pixels white
  cv::Mat colour;      // 8-bit: the largest less the smallest of red, green and blue; empty if the picture is grey
};

constexpr std::int64_t kMaxSheetPixels = 64'000'000;

// PNG of any depth, with transparency; JPEG with EXIF orientation, CMYK too; PGM. INVALID_ARGUMENT: another format,
// damaged, or more than kMaxSheetPixels, which is checked before anything is decoded.
absl::StatusOr<Sheet> DecodeSheet(std::string_view bytes);

// The picture with this diagonal, px, if it is larger.
cv::Mat ShrunkTo(const cv::Mat& image, double diagonal);

}  // namespace enfilade::perception
