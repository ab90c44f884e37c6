// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/door_odds.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace enfilade::rooms {
namespace {

constexpr std::size_t kDepth = 5;
constexpr float kAlways = std::numeric_limits<float>::infinity();

// A complete binary tree. The nodes below split i are 2 i + 1, if the value is at most the threshold, and 2 i + 2; the
// leaves follow the splits.
struct Split {
  std::uint8_t value;  // index into DoorValues
  float threshold;
};
struct DoorTree {
  std::array<Split, (1U << kDepth) - 1U> splits;
  std::array<float, 1U << kDepth> leaves;  // added to the logarithm of the odds of a door
};

#include "core/rooms/door_trees.inc"

double LeafOf(const DoorTree& tree, const DoorValues& values) {
  std::size_t node = 0;
  while (node < tree.splits.size()) {
    const Split& split = tree.splits[node];
    node = 2 * node + (values[split.value] <= static_cast<double>(split.threshold) ? 1U : 2U);
  }
  return static_cast<double>(tree.leaves[node - tree.splits.size()]);
}

}  // namespace

double OpennessOf(const DoorEvidence& evidence) {
  const DoorValues values = ValuesOf(evidence);
  double odds_of_door = kPriorOdds;
  for (const DoorTree& tree : kDoorTrees) odds_of_door += LeafOf(tree, values);
  return -odds_of_door;
}

}  // namespace enfilade::rooms
