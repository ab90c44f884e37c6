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

// What a pair of views of one place has in common, beyond look-alike spots.
enum class GeometricModel {
  kNone,         // nothing is verified: every match counts, as the original did
  kPlanes,       // the planes of the scene: one homography after the other
  kFundamental,  // epipolar geometry of cameras whose intrinsics are not known
  kEssential,    // epipolar geometry with intrinsics
};

// Of a pinhole camera, pixels.
struct Intrinsics {
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
};

struct ImageMatchOptions {
  RatioTest ratios;
  GeometricModel model = GeometricModel::kPlanes;
  // A match is an inlier of a model that maps it this near, as a share of the longer side (3 pixels of 512).
  double tolerance = 0.006;
  // ... and, for planes, if the keypoints' sizes and directions change as the plane's do.
  double size_tolerance = 0.6;   // octaves
  double angle_tolerance = 0.4;  // rad
  int max_planes = 4;
  int min_plane_inliers = 8;  // of the second plane and those after it
  // Accepted when MORE inliers than this are found (the original's feature_matching_thr, which counted unverified
  // matches over two kinds of features, was 30) ...
  int threshold = 15;
  // ... and more than this share of the features in the part that both images show, of the image with fewer there: two
  // doors alike have much that fits, and much more that does not (Brown, Lowe 2007: n_i > alpha + beta n_f).
  double min_share = 0.04;
  std::uint32_t seed = 1;  // of RANSAC
  std::optional<Intrinsics> intrinsics_a;
  std::optional<Intrinsics> intrinsics_b;
};

// The original's: more than 30 matches, whatever their geometry.
ImageMatchOptions OriginalImageMatchOptions();

// INVALID_ARGUMENT naming the option that is out of range, and for kEssential without intrinsics.
absl::Status Validate(const ImageMatchOptions& options);

// Two places that look alike, in pixels of the images as they were decoded.
struct PointPair {
  Eigen::Vector2f a;
  Eigen::Vector2f b;
  bool is_inlier = false;
};

struct ImageMatch {
  bool accepted = false;
  int features_a = 0;
  int features_b = 0;
  int matches = 0;               // past ratio and mutual tests; SIFT and AKAZE at one spot count once
  int inliers = 0;               // that agree on a geometry; with kNone all matches
  int overlap = 0;               // features in the part that both images show, of the image with fewer there
  std::vector<PointPair> pairs;  // the matches
  std::string reason;            // the verdict in words
};

// Do two images show the same place? "No" is a result, not an error, also for images without features. The same
// arguments give the same result. INVALID_ARGUMENT: options, or features whose descriptors are not as many as their
// keypoints. Thread-safe.
absl::StatusOr<ImageMatch> MatchImages(const FeatureSet& a, const FeatureSet& b, const ImageMatchOptions& options = {});

}  // namespace enfilade::perception
