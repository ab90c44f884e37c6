// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/grid/files/rgb_image.h"
#include "perception/image/frame.h"
#include "perception/image/match_images.h"

namespace enfilade::perception {

// The two images side by side, at most 1280 pixels wide together: inliers joined by green lines, other matches by thin
// red ones. INVALID_ARGUMENT: a malformed frame.
absl::StatusOr<grid::RgbImage> DrawMatches(const GreyFrame& a, const GreyFrame& b, const ImageMatch& match);

}  // namespace enfilade::perception
