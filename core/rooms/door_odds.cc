// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/door_odds.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace enfilade::rooms {
namespace {

constexpr float kAlways = std::numeric_limits<float>::infinity();

// A complete binary tree. The nodes below split i are 2 i + 1, if the value is at most the threshold, and 2 i + 2; the
// leaves follow the splits.
struct Split {
  std::uint8_t value;  // index into the values
  float threshold;
};
template <std::size_t kDepth>
struct DoorTree {
  std::array<Split, (1U << kDepth) - 1U> splits;
  std::array<float, 1U << kDepth> leaves;  // added to the logarithm of the odds of a door
};

#include "core/rooms/door_trees.inc"
#include "core/rooms/driven_door_trees.inc"
#include "core/rooms/driven_surrounded_trees.inc"
#include "core/rooms/surrounded_trees.inc"

template <std::size_t kDepth>
double LeafOf(const DoorTree<kDepth>& tree, std::span<const double> values) {
  std::size_t node = 0;
  while (node < tree.splits.size()) {
    const Split& split = tree.splits[node];
    node = 2 * node + (values[split.value] <= static_cast<double>(split.threshold) ? 1U : 2U);
  }
  return static_cast<double>(tree.leaves[node - tree.splits.size()]);
}

template <std::size_t kDepth, std::size_t kTrees>
double OpennessBy(double prior_odds, const std::array<DoorTree<kDepth>, kTrees>& trees,
                  std::span<const double> values) {
  double odds_of_door = prior_odds;
  for (const DoorTree<kDepth>& tree : trees) odds_of_door += LeafOf(tree, values);
  return -odds_of_door;
}

}  // namespace

double DoorOdds::OpennessOf(const DoorEvidence& evidence) const {
  return driven_ ? OpennessBy(kDrivenDoorPriorOdds, kDrivenDoorTrees, ValuesOf(evidence))
                 : OpennessBy(kDoorPriorOdds, kDoorTrees, ValuesOf(evidence));
}

double DoorOdds::OpennessOf(const SurroundedValues& values) const {
  return driven_ ? OpennessBy(kDrivenSurroundedPriorOdds, kDrivenSurroundedTrees, values)
                 : OpennessBy(kSurroundedPriorOdds, kSurroundedTrees, values);
}

}  // namespace enfilade::rooms
