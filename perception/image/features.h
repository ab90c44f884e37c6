// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/image/frame.h"

namespace enfilade::perception {

// A point in an image that can be found again in other views.
struct Keypoint {
  float x = 0.0F;      // pixels of the decoded image
  float y = 0.0F;      // rows from the top
  float size = 0.0F;   // diameter of the described region, pixels
  float angle = 0.0F;  // of its main gradient, rad in [0, 2 pi), clockwise

  friend bool operator==(const Keypoint&, const Keypoint&) = default;
};

constexpr int kSiftBytes = 128;  // unsigned histogram bins (Lowe 2004)
constexpr int kAkazeBytes = 61;  // 486 bits of M-LDB (Alcantarilla, Nuevo, Bartoli 2013)

// Everything that matching needs of an image; can be stored instead of it (feature_codec.h).
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
  // Larger images are first scaled down to this longer side, so that time and thresholds do not depend on the camera.
  int max_side = 640;
  int max_features = 800;  // of each kind, the strongest
  // Half the values proposed by the authors: corridors have little texture. Verification removes weak matches.
  double sift_contrast = 0.02;
  double akaze_threshold = 0.0005;
};

// INVALID_ARGUMENT naming the option that is out of range.
absl::Status Validate(const FeatureOptions& options);

// SIFT and AKAZE features, strongest first. An image without texture, or smaller than 32 pixels, has no features, which
// is not an error. The result does not depend on the number of threads. INVALID_ARGUMENT:
// a malformed frame or options. Thread-safe.
absl::StatusOr<FeatureSet> ExtractFeatures(const GreyFrame& frame, const FeatureOptions& options = {});

}  // namespace enfilade::perception
