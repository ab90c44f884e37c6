// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

namespace enfilade::perception {

// The skeleton of a mask (8-bit, 0 or 255): lines one pixel wide, connected as the mask is. Zhang and Suen's thinning
// (1984), then without the pixels that are needed neither for the connection nor as an end.
cv::Mat Thin(const cv::Mat& mask);

}  // namespace enfilade::perception
