// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/grid/files/rgb_image.h"
#include "perception/cloud/cloud.h"

namespace enfilade::perception {

// Draws both clouds from above, at most 1000 pixels per side: the target in blue, the source over it in red. A white
// pixel if there are no points.
grid::RgbImage DrawClouds(const Cloud& source, const Cloud& target, const Eigen::Isometry3d& T_target_source);

}  // namespace enfilade::perception
