// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "perception/plan/opencv_sheet.h"

namespace enfilade::perception {

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
