// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "perception/image/features.h"

namespace enfilade::perception {

struct RatioTest {
  double sift = 0.6;   // nearest over second nearest distance (Lowe 2004, 7.1); 1 lets everything through
  double akaze = 0.7;  // the same in Hamming distance
  bool mutual = true;  // each must be the other's nearest
};

// Keypoint `a` of one set and `b` of the other look alike.
struct DescriptorMatch {
  int a = 0;
  int b = 0;

  friend bool operator==(const DescriptorMatch&, const DescriptorMatch&) = default;
};

// In the order of `a`; each `a` at most once, and with `mutual` each `b` too. Every descriptor is compared with every
// other: exact, and as fast as an approximate search for as few as there are.
std::vector<DescriptorMatch> MatchSift(const FeatureSet& a, const FeatureSet& b, const RatioTest& test);
std::vector<DescriptorMatch> MatchAkaze(const FeatureSet& a, const FeatureSet& b, const RatioTest& test);

}  // namespace enfilade::perception
