// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/closure/closure_options.h"
#include "core/geometry/pose2.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/link_point.h"
#include "core/graph/plans/plan_ties.h"

namespace enfilade::closure {

// Doors of a floor plan that robots have seen from both sides, in two maps, and not driven through: a candidate of each
// map lies before the door. The plan says that these two candidates are one door, and the scans must confirm it.

// A door of a plan, as it was corrected.
struct PlanDoor {
  Pose2 T_plan_door = {};  // in its middle; x points through it. m, rad
  double width = 0.0;      // m
  double sigma = 0.0;      // m, one standard deviation, in the direction in which it is known least
};

struct PlanWithDoors {
  std::vector<PlanDoor> doors;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> walls;  // m, that robots have not contradicted
  std::vector<graph::MapInPlan> maps;                              // by id; the maps in which its walls were seen
};

// What robots have seen of a door of a plan.
struct SightedDoor {
  enum class State {
    kNotSighted,  // no candidate
    kOneSide,     // candidates on one side only
    kKnown,       // a link point is there already
    kSameMap,     // one map has both sides
    kUnclear,     // see `reason`
    kBothSides,   // two maps, one on each side: to be confirmed
  };
  struct Side {
    MapId map = {};                            // the only one that sees the door from here
    std::vector<LinkPointId> candidates = {};  // the nearest first
    Pose2 T_door_robot = {};                   // of the nearest; x of the door points through it, away from this side
  };

  State state = State::kNotSighted;
  std::vector<LinkPointId> candidates = {};  // all, by id
  std::optional<LinkPointId> link_point = {};
  std::array<Side, 2> sides = {};  // if kBothSides; first the side from which x of the door points away
  std::string reason = {};         // for people; empty if kNotSighted
};

// What robots have seen of each of the plan's doors, by the candidates of `graph`. A candidate is at a door if the door
// is ahead of it (IsDoorOf) with no wall of the plan in between; if two are, at the one that it looks at more exactly,
// if that is clear (clear_chi2), else at none. Each map knows the plan by the walls that it has seen; doors that are
// known less well than sure_radius are left alone, and so are doors that several maps see from one side.
std::vector<SightedDoor> FindSightedDoors(const PlanWithDoors& plan, const graph::GraphSnapshot& graph,
                                          const DoorClosureOptions& options);

// The door in a map of the plan, x pointing through it, away from side 0. Unset: the map is not one of the plan's.
std::optional<PoseWithCovariance> DoorInMap(const PlanWithDoors& plan, const PlanDoor& door, const MapId& map);

}  // namespace enfilade::closure
