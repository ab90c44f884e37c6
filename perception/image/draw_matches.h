// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/grid/files/rgb_image.h"
#include "perception/image/frame.h"
#include "perception/image/match_images.h"

namespace enfilade::perception {

// Draws the two images side by side, at most 1280 pixels wide in total, with green lines between inliers and red lines
// between other matches. INVALID_ARGUMENT: a malformed frame.
absl::StatusOr<grid::RgbImage> DrawMatches(const GreyFrame& a, const GreyFrame& b, const ImageMatch& match);

}  // namespace enfilade::perception
