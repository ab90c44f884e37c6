// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/image/match_images.h"

namespace enfilade::perception {

// A match with the relative size and direction of its keypoints.
struct TentativeMatch {
  Eigen::Vector2f a;
  Eigen::Vector2f b;
  float octaves = 0.0F;   // log2(size in b / size in a)
  float rotation = 0.0F;  // angle in b - angle in a, rad
};

struct Verification {
  std::vector<char> is_inlier;  // per match
  std::vector<float> octaves;   // per match: log2 of an inlier's magnification from a to b, by its plane if known
  std::optional<Eigen::Matrix3d> H_b_a;  // of the plane with the most matches; only with kPlanes
};

// Finds the matches that agree on a geometry. `tolerance_px` is measured in image b. LO-RANSAC (Chum, Matas, Kittler
// 2003) with MSAC's score by OpenCV's USAC framework, seeded with options.seed.
absl::StatusOr<Verification> VerifyGeometry(const std::vector<TentativeMatch>& matches, double tolerance_px,
                                            const ImageMatchOptions& options);

}  // namespace enfilade::perception
