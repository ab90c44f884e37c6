// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/environment.h"
#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point.h"

namespace enfilade::survey {

// A survey sees one level of a site as a whole: all drives in one frame, the level's. It is the evidence by which maps
// are arranged until each is one room (ArrangeMaps). Values only.

// A keyframe of a session, in both frames.
struct Visit {
  std::int64_t sequence = 0;  // of the scan's record in the session's log
  TimeNs time = 0;
  Pose2 T_map_robot = {};    // as the session's own mapping has it
  Pose2 T_level_robot = {};  // as the survey has it
};

// A robot went into the cabin of a lift that is a map of another level, and was well inside before its session ended.
struct CabinEntry {
  MapId cabin = {};
  LinkPointId door = {};
  std::vector<Visit> visits = {};  // behind the door; without T_level_robot
};

// A ride that began on this level: its session goes on in a cabin where one of this level ended.
struct RideBegun {
  SessionId session = {};
  MapId cabin = {};
  Pose2 T_level_robot = {};                 // where the robot was when it began, by this level
  Pose2 T_cabin_robot = {};                 // and by the ride
  std::optional<LinkPointId> way_out = {};  // made for the door by which the robot came out, if it was new
};

struct SurveyedSession {
  SessionId id = {};
  MapId map = {};
  std::optional<Pose2> T_map_entry = {};  // where the robot entered the map, if that is known
  std::vector<Visit> visits = {};         // in the order of the log; may be empty
  std::optional<TimeNs> left = {};        // when the robot went through the door at the session's end, if it did
  std::optional<CabinEntry> cabin = {};   // if that door is a cabin's; `visits` end at it
};

// What one robot recorded without a break: each session but the first follows its predecessor through a door.
using Drive = std::vector<SurveyedSession>;

// A session in the cabin of a lift that is in no drive, because it was entered from another level.
struct Ride {
  SessionId session = {};
  std::vector<Pose2> T_map_robot = {};  // of its keyframes
};

struct SurveyedMap {
  MapId id = {};
  Environment environment = Environment::kIndoor;
  std::string slam_profile = {};
  bool root = false;  // its frame is the world's
  // Something still happens in it that the survey does not contain: a session is recording or not mapped yet. A busy
  // map stays.
  bool busy = false;
  // People have decided which sessions it has: none leaves it, and the rooms that they drove in are one map.
  bool pinned = false;
  std::vector<Ride> rides = {};  // if it is the cabin of a lift

  // A map with rides goes only where they can go with it: into the map of the same cabin.
  bool stays() const { return busy || !rides.empty(); }
};

// A map that a verdict began behind a door, and into which no session has come: the drive ended there.
struct AwaitedMap {
  MapId id = {};
  Pose2 T_level_map = {};
  Pose2 T_level_robot = {};  // where the robot was when it was to enter
};

// What a robot took for a door, seen from the anchor of the candidate that was made for it.
struct SeenGap {
  Pose2 T_place_gap = {};  // its middle, facing through it
  double width = 0.0;      // m
};

struct LevelSurvey {
  int level = 0;
  std::vector<Drive> drives = {};
  double variance_factor = 1.0;        // of the drives' SLAM (core/slam/state/variance_factor.h), the largest
  std::vector<SurveyedMap> maps = {};  // all maps of the level's sessions
  std::vector<AwaitedMap> awaited = {};
  std::vector<graph::LinkPoint> link_points = {};  // of the whole site: a changed one may equal another level's
  // Of link_points: doors that robots saw through from both sides (core/closure/plans/match_door.h).
  std::set<LinkPointId> seen_through = {};
  std::map<LinkPointId, SeenGap> gaps = {};  // of link_points: of those candidates whose gap is known
  std::set<MapId> cabins = {};               // of lifts: maps of other levels in which robots came to another one
  // T_level_cabin: by the level's first robot, if it came in the cabin. When it came out, it was in both maps.
  std::map<MapId, Pose2> cabin_places = {};
  std::vector<RideBegun> rides_begun = {};

  const SurveyedMap* FindMap(const MapId& id) const;
};

// T_level_map of a session: the rigid motion that takes its own poses to the survey's (least squares over its visits).
// Unset without visits.
std::optional<Pose2> PlaceOf(const SurveyedSession& session);

}  // namespace enfilade::survey
