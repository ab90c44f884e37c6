// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/rooms/door_evidence.h"
#include "core/rooms/surroundings.h"

namespace enfilade::rooms {

// The logarithm of the odds that a candidate is open ground (positive) against a door (negative), by gradient boosted
// regression trees (J. Friedman, "Greedy function approximation: a gradient boosting machine", 2001). tests/bench/
// fit_door_trees fits them to candidates of which the truth is known, and writes door_trees.inc.
double OpennessOf(const DoorEvidence& evidence);

// The same once it is known what surrounds the line. `driven`: robots drove in the map and reported passages
// (RoomEvidence), and the line is not much wider than what they report (WidestReported). What they report and what they
// pass in silence tells doors from other openings that look alike; so the trees are others (driven_trees.inc) than
// those of a map alone (surrounded_trees.inc).
double OpennessOf(const SurroundedValues& values, bool driven);

}  // namespace enfilade::rooms
