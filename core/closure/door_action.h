// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/environment.h"
#include "core/base/ids.h"
#include "core/closure/closure_options.h"
#include "core/closure/door_knowledge.h"
#include "core/closure/door_verdict.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point.h"

namespace enfilade::closure {

// A map that starts at a door.
struct MapToStart {
  MapId id = {};
  int level = 0;
  Environment environment = Environment::kIndoor;
  std::string slam_profile = {};
};

// Level and environment are the report's, or those of the map that the robot comes from. Both may be missing (null).
MapToStart DescribeNewMap(const MapId& id, const SessionMap* from, const sensor::DoorReport* report,
                          const DoorClosureOptions& options);

// The map that the robot is in after a passage, and its pose there when it reports; unset: not known.
struct EnteredMap {
  MapId map = {};
  std::optional<PoseWithCovariance> T_map_robot = {};
};

// What is to be done about a report. Ids of what is made are those of DoorKnowledge.

// The report cannot be judged. A passage leads into a new map that no link point joins.
struct LeaveUnjudged {
  std::optional<MapToStart> map = {};
};
// The map knows the door that was seen.
struct KeepKnownCandidate {
  LinkPointId link_point = {};
};
struct MakeCandidate {
  graph::LinkPoint candidate = {};
};
// The robot came through a link point that joins both maps already.
struct RecogniseLinkPoint {
  LinkPointId link_point = {};
  EnteredMap entered = {};
};
// The robot came through a link point of other maps: the session's map is joined to it, too.
struct JoinLinkPoint {
  LinkPointId link_point = {};
  graph::Anchor anchor = {};  // in the session's map
  EnteredMap entered = {};
};
// The candidate was seen from before the door; the link point is the door itself.
struct PromoteCandidate {
  LinkPointId link_point = {};
  graph::LinkPointKind kind = graph::LinkPointKind::kDoor;
  std::vector<graph::Anchor> anchors = {};
  EnteredMap entered = {};
};
// A new link point between two known maps.
struct LinkKnownMaps {
  graph::LinkPoint link_point = {};
  EnteredMap entered = {};
};
// A new link point, and a new map whose origin it is.
struct StartMap {
  MapToStart map = {};
  graph::LinkPoint link_point = {};
  EnteredMap entered = {};
};
// Maps that may be the entered one are still being mapped: decide again later.
struct WaitForMapping {
  std::vector<std::string> maps = {};  // display names
};

using DoorAction = std::variant<LeaveUnjudged, KeepKnownCandidate, MakeCandidate, RecogniseLinkPoint, JoinLinkPoint,
                                PromoteCandidate, LinkKnownMaps, StartMap, WaitForMapping>;

// An action, and why.
struct DoorJudgement {
  DoorAction action = LeaveUnjudged{};
  std::string reason = {};
  std::vector<DoorComparison> comparisons = {};  // the best first
  std::vector<LinkPointId> used_up = {};         // candidates that the link point replaces
};

// The judgement as a verdict, without what belongs to the report (session, sequence, graph version, odometry). Not for
// WaitForMapping.
DoorVerdict ToVerdict(const DoorJudgement& judgement);

// "candidate made", as in docs/closure.md.
const char* NameOf(DoorDecision decision);

// The existing link point or candidate that the action changes; null if it changes none.
const LinkPointId* FindChangedLinkPoint(const DoorAction& action);

}  // namespace enfilade::closure
