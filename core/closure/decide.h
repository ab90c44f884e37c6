// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <variant>
#include <vector>

#include "core/closure/door_action.h"
#include "core/closure/door_knowledge.h"

namespace enfilade::closure {

// Search the graph (GraphSearch) ...
struct SearchGraph {
  enum class Target {
    kPassedDoor,  // for link points of the session's own map: sets `passed`
    kPlaces,      // for places of other maps: sets `places`
    kMaps,        // for maps in which scans may find the robot: sets `maps`
  };
  Target target = Target::kPassedDoor;
};
// ... compare the images of these places with those behind the door: sets `evidence.images` if there are any to
// compare, and `images_compared` ...
struct CompareImages {
  std::vector<PlaceIndex> places;
};
// ... register the clouds of this place: sets `evidence.clouds` and `clouds_compared` in the same way ...
struct CompareClouds {
  PlaceIndex place;
};
// ... match the scans behind the door with what robots have seen of this map: sets `maps[map].scans` ...
struct MatchScans {
  std::size_t map = 0;
};
// ... or nothing more: this is what to do.
using DoorStep = std::variant<SearchGraph, CompareImages, CompareClouds, MatchScans, DoorJudgement>;

// What to find out next about a door report, or what to do about it. Pure: the same knowledge gives the same step. The
// caller adds what the step asks for to the knowledge and calls again. Every step but the last one fills in something
// that was missing, so the sequence ends with a judgement. The order is that of cost: the graph, images, clouds, scans
// (docs/closure.md).
DoorStep Decide(const DoorKnowledge& knowledge);

}  // namespace enfilade::closure
