// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/image/match_images.h"

namespace enfilade::perception {

// The robot's camera images at one moment, or the stored images of a door. Null: no image of that camera.
struct Views {
  const FeatureSet* front = nullptr;
  const FeatureSet* rear = nullptr;
};

// The robot's heading relative to that of the stored images.
enum class Heading {
  kSame,      // front matches stored front, rear matches stored rear
  kOpposite,  // front matches stored rear, rear matches stored front
};

struct SeriesMatch {
  bool accepted = false;
  bool other_place = false;          // not accepted, and at some moment the same view from another place (ImageMatch)
  Heading heading = Heading::kSame;  // of the better hypothesis
  int score = 0;                     // median over the series; for an even number the integer mean of the middle two
  int other_score = 0;               // of the other heading
  std::vector<int> scores;           // per moment, for `heading`
  std::string reason;
};

// Compares a stored door with a series of moments. The score of a moment is the sum over its pairs of images, for each
// heading; a pair that is not accepted counts zero, so that noise does not add up. Accepted if the median is above
// options.threshold. For a candidate, which has only a rear image, leave the other images null. INVALID_ARGUMENT: an
// empty series, no stored image, options.
absl::StatusOr<SeriesMatch> MatchSeries(const Views& stored, std::span<const Views> series,
                                        const ImageMatchOptions& options = {});

}  // namespace enfilade::perception
