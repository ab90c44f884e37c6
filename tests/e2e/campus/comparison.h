// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tests/e2e/campus/drive_truth.h"
#include "tests/e2e/campus/mapped_state.h"

namespace enfilade::testing {

// When a map counts as a map of an area, and a pose as right.
struct ComparisonOptions {
  // m of driving before and behind a door that are in neither area: a session may end 2 m behind the door.
  double before_door = 1.0;
  double behind_door = 2.5;
  // A map is one of an area's if it has more than both of the area's time.
  double share = 0.1;
  double seconds = 2.0;
  double at_door = 1.0;       // m between a link point and the line between the door's jambs
  double misplaced = 1.0;     // m
  double misturned = 0.1745;  // rad, 10 deg
  bool doors = true;          // false: their places are not known, so link points are not compared
};

// The maps of a site compared with the truth, as they are when everything is done. What was answered on the way does
// not matter.
struct Comparison {
  int areas = 0;          // that robots entered
  int maps = 0;           // of the site
  int areas_doubled = 0;  // several maps
  int areas_missing = 0;  // no map, or one that is mostly another area's
  int maps_merged = 0;    // the main map of several areas
  int maps_extra = 0;     // no area's main map

  int doors = 0;          // that robots passed
  int joins = 0;          // link points that join maps
  int doors_doubled = 0;  // several link points at the door that join its two areas
  int doors_missing = 0;  // none
  int joins_wrong = 0;    // at a door that was passed, but joining other maps than its two areas'
  int joins_false = 0;    // where no door was passed, or without a place in the world
  int candidates = 0;     // link points in one map
  int components = 0;     // pieces of the graph

  int passages = 0;
  int stretches = 0;          // between passages
  int false_placements = 0;   // stretches of which more than a tenth is misplaced or misturned in the world
  double unplaced_s = 0.0;    // time of poses that are mapped, but without a place in the world
  double unmapped_s = 0.0;    // time of true poses that are not mapped
  double position_rms = 0.0;  // m, of all poses in the world
  double position_max = 0.0;  // m
  double yaw_max = 0.0;       // rad
  // One map for each area that was entered, one link point for each door that was passed, no others, in one piece. If
  // every door of the campus was passed, also no candidate.
  bool exact = false;
  std::vector<std::string> wrong;  // why it is not exact, for people

  Pose2 T_campus_world;
};

// `doors`: of the campus. The world is aligned by the first pose of the first robot that has one. Throws if `truths` is
// empty.
Comparison Compare(const std::vector<DriveTruth>& truths, const std::vector<TrueDoor>& doors, const MappedState& state,
                   const ComparisonOptions& options = {});

}  // namespace enfilade::testing
