// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/rooms/door_evidence.h"
#include "core/rooms/room_partition.h"
#include "core/rooms/surroundings.h"

namespace enfilade::rooms {

// The logarithm of the odds that a line is open ground (positive) against a door (negative), by gradient boosted
// regression trees (J. Friedman, "Greedy function approximation: a gradient boosting machine", 2001). tests/bench/
// fit_door_trees fits them to lines of which the truth is known, and writes the *_trees.inc.
class DoorOdds {
 public:
  // Where robots reported passages, what they report and what they pass in silence tells doors from other openings that
  // look alike. So the trees are others (driven_*) than those of a map alone.
  explicit DoorOdds(const RoomEvidence& evidence) : driven_(!evidence.passages.empty()) {}

  double OpennessOf(const DoorEvidence& evidence) const;
  // The same once it is known what surrounds the line.
  double OpennessOf(const SurroundedValues& values) const;

 private:
  bool driven_;
};

}  // namespace enfilade::rooms
