// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

namespace enfilade::testing {

// A camera that looks at the middle of a sheet of paper on a table.
struct PhotoOptions {
  double tilt_deg = 20;        // about the photo's horizontal axis
  double pan_deg = 0;          // about its vertical axis
  double roll_deg = 4;         // about the line of sight
  double focal = 0.75;         // of the photo's diagonal
  double fill = 0.8;           // of the photo that the paper takes at most, along a side
  double shade_at_edge = 0.7;  // light at the right edge of the photo, 1 at the left
  double noise = 3;            // grey levels, standard deviation
  double table = 0.35;         // brightness of the table, of the paper's; it has a grain
  std::uint32_t seed = 1;
};

struct Photo {
  std::string png;
  Eigen::Matrix3d H_photo_sheet;  // from pixels of the sheet's picture
};

// `sheet`: a grey PNG.
Photo TakePhoto(const std::string& sheet, const PhotoOptions& options = {});

}  // namespace enfilade::testing
