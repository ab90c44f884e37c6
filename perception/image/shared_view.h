// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "perception/image/features.h"
#include "perception/image/match_images.h"

namespace enfilade::perception {

// How much of what two images show is the same, seen from about the same place. Two views along one corridor from
// places metres apart have many matches too: those of what is far ahead. But then the near field has none.
struct SharedView {
  // The share of the features with an inlier of about the same size in the other image, the mean over the cells that
  // have features, in the part that both images show; of the image where it is less. Cells give the near field, at the
  // border, its weight: far along a corridor much is seen in a small part of the image. (Cells as in Bian et al. 2017,
  // Grid-based Motion Statistics.)
  double share = 0.0;
  // Whether the magnification can be that of a moving camera. A point at depth Z is magnified by Z / (Z - d) if the
  // camera moves by d towards it (Longuet-Higgins, Prazdny 1980), so what is near, away from the image's centre, must
  // grow more than what is far. Repeated doors beside a nearer end wall do not.
  bool parallax_agrees = true;
  // How far the inliers move from image to image on average, as a share of the longer side: large if the camera turned
  // or moved aside. Then another part of the near field is in view, and `share` tells little.
  double shift = 0.0;
};

// `H_b_a`: the homography that tells the part that both show; nothing: all. `max_octaves`: log2 of the largest
// magnification that counts as about the same size.
SharedView CompareViews(const FeatureSet& a, const FeatureSet& b, const std::vector<PointPair>& pairs,
                        const std::optional<Eigen::Matrix3d>& H_b_a, double max_octaves);

// Whether the homography H_b_a takes a point of image a into image b.
bool IsShownIn(const FeatureSet& b, const Eigen::Matrix3d& H_b_a, const Keypoint& in_a);

}  // namespace enfilade::perception
