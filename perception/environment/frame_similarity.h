// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "absl/status/statusor.h"
#include "core/base/environment.h"
#include "perception/image/frame.h"

namespace enfilade::perception {

// Mean structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004) of images of 8 bits: a Gaussian window of 11x11
// with sigma 1.5, C1 = (0.01 * 255)^2, C2 = (0.03 * 255)^2; -1 .. 1, and 1 for equal images. INVALID_ARGUMENT:
// malformed frames or of different sizes.
absl::StatusOr<double> StructuralSimilarity(const GreyFrame& a, const GreyFrame& b);

// 10 log10(255^2 / mean squared difference), dB. Equal images have +infinity (the original's function gave 0, so that a
// standing robot would have looked outdoors). INVALID_ARGUMENT as above.
absl::StatusOr<double> PeakSignalToNoise(const GreyFrame& a, const GreyFrame& b);

// Depth as brightness: 0 for 0 m up to 255 for `max_depth` (m) and beyond; 0 where nothing was measured.
GreyFrame BrightnessOf(const DepthFrame& frame, double max_depth);

enum class SimilarityMeasure {
  kSsim,  // criterion 1 of the original
  kPsnr,  // criterion 2
};

// Depth cameras see little of what is far away or in the sun, and see it differently each time: consecutive depth
// images that are unlike each other were taken outdoors.
struct SimilarityCriterion {
  SimilarityMeasure measure = SimilarityMeasure::kSsim;
  double threshold = 0.7;   // a mean below it is outdoors; the original's psnr_thr is 0.0 dB, which nothing is below
  int frames = 10;          // num_depth_imgs; the code of the original: 5
  double max_depth = 10.0;  // m, of BrightnessOf
};

absl::Status Validate(const SimilarityCriterion& criterion);

struct SimilarityChoice {
  Environment environment = Environment::kIndoor;
  double mean = 0.0;  // over consecutive pairs; +infinity where all were equal by PSNR
  int pairs = 0;
};

// Of the first `frames` frames, or of all where there are fewer. INVALID_ARGUMENT: fewer than two frames, malformed
// frames, different sizes, criterion.
absl::StatusOr<SimilarityChoice> ChooseBySimilarity(std::span<const DepthFrame> frames,
                                                    const SimilarityCriterion& criterion = {});

}  // namespace enfilade::perception
