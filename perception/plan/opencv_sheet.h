// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
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

// A sheet of paper on something darker, as a camera sees it.
struct Page {
  cv::Matx33d H_page_photo;  // from pixels of the photo to those of the page as if seen from straight above
  cv::Size size;             // of the page, px
};

// Finds the page in a photo: a bright quadrilateral with straight sides that lies within the picture, on a background
// that is at least 20 grey levels darker beside every side and is not even, as drawn areas and the unknown of maps are.
// Its aspect ratio follows from the perspective of a camera that looks at the picture's centre (Zhang and He,
// Whiteboard scanning and image enhancement, Digital Signal Processing 17, 2007). nullopt: this is no such photo.
std::optional<Page> FindPage(const cv::Mat& brightness);

Sheet Rectify(const Sheet& photo, const Page& page);

}  // namespace enfilade::perception
