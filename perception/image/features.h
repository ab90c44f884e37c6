// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/image/frame.h"

namespace enfilade::perception {

// A spot in an image that is found again from other views.
struct Keypoint {
  float x = 0.0F;      // pixels of the image as it was decoded
  float y = 0.0F;      // rows from the top
  float size = 0.0F;   // diameter of what it describes, pixels
  float angle = 0.0F;  // of its main gradient, rad in [0, 2 pi), clockwise as seen

  friend bool operator==(const Keypoint&, const Keypoint&) = default;
};

constexpr int kSiftBytes = 128;  // unsigned histogram bins (Lowe 2004)
constexpr int kAkazeBytes = 61;  // 486 bits of M-LDB (Alcantarilla, Nuevo, Bartoli 2013)

// All that matching needs of an image, so that it can be kept instead of the image (feature_codec.h).
struct FeatureSet {
  int width = 0;  // of the image, pixels
  int height = 0;
  std::vector<Keypoint> sift;
  std::vector<std::uint8_t> sift_descriptors;  // kSiftBytes per keypoint
  std::vector<Keypoint> akaze;
  std::vector<std::uint8_t> akaze_descriptors;  // kAkazeBytes per keypoint

  friend bool operator==(const FeatureSet&, const FeatureSet&) = default;
};

struct FeatureOptions {
  // Larger images are scaled down to this longer side first: time and thresholds then depend on no camera.
  int max_side = 640;
  int max_features = 800;  // of each kind, the strongest
  // Half of what the authors propose: corridors have little texture. What is too weak does not survive verification.
  double sift_contrast = 0.02;
  double akaze_threshold = 0.0005;
};

// INVALID_ARGUMENT naming the option that is out of range.
absl::Status Validate(const FeatureOptions& options);

// SIFT and AKAZE features, strongest first. None where there is nothing to see (a black image, one smaller than 32
// pixels): that is no error. The same frame gives the same features whatever the number of threads. INVALID_ARGUMENT:
// a malformed frame or options. Thread-safe.
absl::StatusOr<FeatureSet> ExtractFeatures(const GreyFrame& frame, const FeatureOptions& options = {});

}  // namespace enfilade::perception
