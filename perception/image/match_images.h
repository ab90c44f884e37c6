// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/image/descriptor_matching.h"
#include "perception/image/features.h"

namespace enfilade::perception {

// The geometry that matches of two views of one place must satisfy.
enum class GeometricModel {
  kNone,         // no verification: every match counts, as in map_manager
  kPlanes,       // the scene's planes: one homography after another
  kFundamental,  // epipolar geometry of cameras with unknown intrinsics
  kEssential,    // epipolar geometry with intrinsics
};

// Intrinsics of a pinhole camera, pixels.
struct Intrinsics {
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
};

struct ImageMatchOptions {
  RatioTest ratios;
  GeometricModel model = GeometricModel::kPlanes;
  // Largest error of an inlier, as a share of the longer side (3 pixels of 512).
  double tolerance = 0.006;
  // For planes, the keypoints' sizes and directions must also agree with the homography.
  double size_tolerance = 0.6;   // octaves
  double angle_tolerance = 0.4;  // rad
  int max_planes = 4;
  int min_plane_inliers = 8;  // of the second and later planes
  // Accepted if there are MORE inliers than this. (map_manager's feature_matching_thr of 30 counts unverified matches
  // of two kinds of features.)
  int threshold = 15;
  // There must also be more than this share of the features in the part that both images show, counted in the image
  // with fewer of them: two similar doors have many features that match, and many more that do not (Brown, Lowe 2007:
  // n_i > alpha + beta n_f).
  double min_share = 0.04;
  // Of images that look the same way, so that inliers move by at most max_shift of the longer side on average, more
  // than this share of the features must have an inlier of about the same size (max_octaves), the mean over the image's
  // cells: the near field counts as what is far ahead does (shared_view.h). 0: not tested.
  double min_view_share = 0.05;
  double max_octaves = 0.6;
  double max_shift = 0.125;
  std::uint32_t seed = 1;  // of RANSAC
  std::optional<Intrinsics> intrinsics_a;
  std::optional<Intrinsics> intrinsics_b;
};

// map_manager's published parameters: more than 30 matches of any geometry.
ImageMatchOptions MapManagerImageMatchOptions();

// INVALID_ARGUMENT naming the option that is out of range, and for kEssential without intrinsics.
absl::Status Validate(const ImageMatchOptions& options);

// A pair of matched points, in pixels of the decoded images.
struct PointPair {
  Eigen::Vector2f a;
  Eigen::Vector2f b;
  bool is_inlier = false;
  float octaves = 0.0F;  // log2 of the magnification from a to b, of an inlier
};

struct ImageMatch {
  bool accepted = false;
  // There are inliers enough, but of far parts only or without a camera's parallax: the same view from another place,
  // such as farther along a corridor. Then not accepted.
  bool other_place = false;
  int features_a = 0;
  int features_b = 0;
  int matches = 0;               // after ratio and mutual tests; SIFT and AKAZE at one point count once
  int inliers = 0;               // that agree on a geometry; with kNone all matches
  double view_share = 0.0;       // with an inlier of about the same size, mean over the image's cells
  int overlap = 0;               // features in the part that both images show, in the image with fewer of them
  std::vector<PointPair> pairs;  // the matches
  std::string reason;            // human-readable
};

// Decides whether two images show the same place. "No" is a result, not an error, even for images without features.
// Deterministic. INVALID_ARGUMENT: options, or different numbers of descriptors and keypoints. Thread-safe.
absl::StatusOr<ImageMatch> MatchImages(const FeatureSet& a, const FeatureSet& b, const ImageMatchOptions& options = {});

}  // namespace enfilade::perception
