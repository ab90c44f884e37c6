// SPDX-License-Identifier: Apache-2.0
#include "perception/image/descriptor_matching.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <opencv2/core/hal/hal.hpp>

namespace enfilade::perception {
namespace {

constexpr int kNone = std::numeric_limits<int>::max();

struct Nearest {
  int index = -1;
  int distance = kNone;
  int second = kNone;

  void Offer(int candidate, int candidate_distance) {
    if (candidate_distance < distance) {
      second = distance;
      distance = candidate_distance;
      index = candidate;
    } else if (candidate_distance < second) {
      second = candidate_distance;
    }
  }
};

// `ratio` applies to what `distance` returns. Each pair is compared once for both directions.
template <typename Distance>
std::vector<DescriptorMatch> Match(std::size_t count_a, std::size_t count_b, double ratio, bool mutual,
                                   const Distance& distance) {
  std::vector<DescriptorMatch> matches;
  if (count_a < 2 || count_b < 2) return matches;  // no second nearest to compare with
  std::vector<Nearest> of_a(count_a);
  std::vector<Nearest> of_b(count_b);
  for (std::size_t a = 0; a < count_a; ++a) {
    for (std::size_t b = 0; b < count_b; ++b) {
      const int d = distance(a, b);
      of_a[a].Offer(static_cast<int>(b), d);
      of_b[b].Offer(static_cast<int>(a), d);
    }
  }
  for (std::size_t a = 0; a < count_a; ++a) {
    const Nearest& nearest = of_a[a];
    if (!(nearest.distance < ratio * nearest.second)) continue;
    if (mutual && of_b[static_cast<std::size_t>(nearest.index)].index != static_cast<int>(a)) continue;
    matches.push_back({static_cast<int>(a), nearest.index});
  }
  return matches;
}

std::vector<std::int16_t> Widen(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

// 16-bit factors: the compiler multiplies and adds eight at a time.
int SquaredDistance(const std::int16_t* a, const std::int16_t* b) {
  int sum = 0;
  for (int i = 0; i < kSiftBytes; ++i) {
    const auto difference = static_cast<std::int16_t>(a[i] - b[i]);
    sum += difference * difference;
  }
  return sum;
}

}  // namespace

std::vector<DescriptorMatch> MatchSift(const FeatureSet& a, const FeatureSet& b, const RatioTest& test) {
  const std::vector<std::int16_t> bins_a = Widen(a.sift_descriptors);
  const std::vector<std::int16_t> bins_b = Widen(b.sift_descriptors);
  return Match(a.sift.size(), b.sift.size(), test.sift * test.sift, test.mutual, [&](std::size_t i, std::size_t j) {
    return SquaredDistance(&bins_a[i * kSiftBytes], &bins_b[j * kSiftBytes]);
  });
}

std::vector<DescriptorMatch> MatchAkaze(const FeatureSet& a, const FeatureSet& b, const RatioTest& test) {
  return Match(a.akaze.size(), b.akaze.size(), test.akaze, test.mutual, [&](std::size_t i, std::size_t j) {
    return cv::hal::normHamming(&a.akaze_descriptors[i * kAkazeBytes], &b.akaze_descriptors[j * kAkazeBytes],
                                kAkazeBytes);
  });
}

}  // namespace enfilade::perception
