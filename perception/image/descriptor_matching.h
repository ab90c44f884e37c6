// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "perception/image/features.h"

namespace enfilade::perception {

struct RatioTest {
  double sift = 0.6;   // nearest over second nearest distance (Lowe 2004, 7.1); 1 accepts all
  double akaze = 0.7;  // the same in Hamming distance
  bool mutual = true;  // both must be each other's nearest
};

// Keypoint `a` of one set matches `b` of the other.
struct DescriptorMatch {
  int a = 0;
  int b = 0;

  friend bool operator==(const DescriptorMatch&, const DescriptorMatch&) = default;
};

// Ordered by `a`; each `a` occurs at most once, with `mutual` each `b` too. Exhaustive comparison: exact, and for so
// few descriptors as fast as an approximate search.
std::vector<DescriptorMatch> MatchSift(const FeatureSet& a, const FeatureSet& b, const RatioTest& test);
std::vector<DescriptorMatch> MatchAkaze(const FeatureSet& a, const FeatureSet& b, const RatioTest& test);

}  // namespace enfilade::perception
