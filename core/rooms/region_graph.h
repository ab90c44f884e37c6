// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace enfilade::rooms {

// A border between two regions. Positive: they are rather one room; negative: rather two.
struct RegionBorder {
  int one = 0;
  int other = 0;
  double weight = 0.0;
};

// The partition of regions into rooms that these borders support together: borders between the same two rooms add up,
// so that one open side joins what a single door would part. Correlation clustering by greedy additive edge contraction
// (M. Keuper et al., "Efficient decomposition of image and mesh graphs by lifted multicuts", 2015). Returns the room of
// each region, from 0.
std::vector<int> ClusterRegions(int regions, std::span<const RegionBorder> borders);

}  // namespace enfilade::rooms
