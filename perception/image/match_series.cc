// SPDX-License-Identifier: Apache-2.0
#include "perception/image/match_series.h"

#include <algorithm>
#include <cstddef>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::perception {
namespace {

// `other_place` becomes true if the pair is the same view from another place.
absl::StatusOr<int> Score(const FeatureSet* stored, const FeatureSet* seen, const ImageMatchOptions& options,
                          bool& other_place) {
  if (stored == nullptr || seen == nullptr) return 0;
  ENFILADE_ASSIGN_OR_RETURN(const ImageMatch match, MatchImages(*stored, *seen, options));
  other_place = other_place || match.other_place;
  return match.accepted ? match.inliers : 0;
}

int Median(std::vector<int> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

}  // namespace

absl::StatusOr<SeriesMatch> MatchSeries(const Views& stored, std::span<const Views> series,
                                        const ImageMatchOptions& options) {
  if (series.empty()) return InvalidArgument("the series of images is empty");
  if (stored.front == nullptr && stored.rear == nullptr) return InvalidArgument("no image is stored to compare with");
  std::vector<int> same;
  std::vector<int> opposite;
  bool other_place = false;
  for (const Views& seen : series) {
    ENFILADE_ASSIGN_OR_RETURN(const int front_front, Score(stored.front, seen.front, options, other_place));
    ENFILADE_ASSIGN_OR_RETURN(const int rear_rear, Score(stored.rear, seen.rear, options, other_place));
    ENFILADE_ASSIGN_OR_RETURN(const int rear_front, Score(stored.rear, seen.front, options, other_place));
    ENFILADE_ASSIGN_OR_RETURN(const int front_rear, Score(stored.front, seen.rear, options, other_place));
    same.push_back(front_front + rear_rear);
    opposite.push_back(rear_front + front_rear);
  }
  SeriesMatch match;
  match.score = Median(same);
  match.other_score = Median(opposite);
  match.scores = std::move(same);
  if (match.other_score > match.score) {
    match.heading = Heading::kOpposite;
    std::swap(match.score, match.other_score);
    match.scores = std::move(opposite);
  }
  match.accepted = match.score > options.threshold;
  match.other_place = !match.accepted && other_place;
  match.reason =
      fmt::format("{}median of {} moments is {} inliers: {} {}", match.other_place ? "same view, other place: " : "",
                  series.size(), match.score, match.accepted ? "more than" : "not above", options.threshold);
  return match;
}

}  // namespace enfilade::perception
