// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/image/match_images.h"

namespace enfilade::perception {

// What the robot's cameras see at one moment, or what is stored of a door. A camera that there is no image of is null.
struct Views {
  const FeatureSet* front = nullptr;
  const FeatureSet* rear = nullptr;
};

// How the robot faces, against when the stored images were taken.
enum class Heading {
  kSame,      // front looks like stored front, rear like stored rear
  kOpposite,  // front looks like stored rear, rear like stored front
};

// The series of the original: 6 moments.
constexpr int kDefaultSeriesLength = 6;

struct SeriesMatch {
  bool accepted = false;
  Heading heading = Heading::kSame;  // of the better hypothesis
  int score = 0;                     // median over the series; of an even number the whole mean of the middle two
  int other_score = 0;               // of the other heading
  std::vector<int> scores;           // per moment, for `heading`
  std::string reason;
};

// Compares a stored door with a series of moments. The score of one moment is the sum over its pairs of images, for
// each heading; a pair that is not accepted by itself counts zero, so that noise does not add up. Accepted when the
// median is above options.threshold. A candidate, of which the rear image only is stored, is compared with front images
// by leaving the others null. INVALID_ARGUMENT: an empty series, nothing stored, options.
absl::StatusOr<SeriesMatch> MatchSeries(const Views& stored, std::span<const Views> series,
                                        const ImageMatchOptions& options = {});

}  // namespace enfilade::perception
