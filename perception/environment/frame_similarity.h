// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "absl/status/statusor.h"
#include "core/base/environment.h"
#include "perception/image/frame.h"

namespace enfilade::perception {

// Mean structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004) of images of 8 bits: a Gaussian window of 11x11
// with sigma 1.5, C1 = (0.01 * 255)^2, C2 = (0.03 * 255)^2; in [-1, 1], 1 for equal images. INVALID_ARGUMENT: malformed
// frames, or different sizes.
absl::StatusOr<double> StructuralSimilarity(const GreyFrame& a, const GreyFrame& b);

// 10 log10(255^2 / mean squared difference), dB; +infinity for equal images. (map_manager gives 0 there, so a robot
// that stands still seems to be outdoors.) INVALID_ARGUMENT as above.
absl::StatusOr<double> PeakSignalToNoise(const GreyFrame& a, const GreyFrame& b);

// Depth as brightness: 0 for 0 m to 255 for `max_depth` (m) and beyond; 0 without a measurement.
GreyFrame BrightnessOf(const DepthFrame& frame, double max_depth);

enum class SimilarityMeasure {
  kSsim,  // map_manager's criterion 1
  kPsnr,  // criterion 2
};

// Depth cameras measure distant or sunlit surfaces poorly and differently each time: dissimilar consecutive depth
// images indicate outdoors.
struct SimilarityCriterion {
  SimilarityMeasure measure = SimilarityMeasure::kSsim;
  double threshold = 0.7;   // a mean below it is outdoors; map_manager's psnr_thr is 0.0 dB, which no pair is below
  int frames = 10;          // num_depth_imgs; 5 by default in map_manager's code
  double max_depth = 10.0;  // m, of BrightnessOf
};

absl::Status Validate(const SimilarityCriterion& criterion);

struct SimilarityChoice {
  Environment environment = Environment::kIndoor;
  double mean = 0.0;  // over consecutive pairs; +infinity if any pair is equal by PSNR
  int pairs = 0;
};

// Uses the first `frames` frames, or all if there are fewer. INVALID_ARGUMENT: fewer than two frames, malformed
// frames, different sizes, criterion.
absl::StatusOr<SimilarityChoice> ChooseBySimilarity(std::span<const DepthFrame> frames,
                                                    const SimilarityCriterion& criterion = {});

}  // namespace enfilade::perception
