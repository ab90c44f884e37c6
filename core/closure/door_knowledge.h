// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/environment.h"
#include "core/base/ids.h"
#include "core/closure/closure_options.h"
#include "core/closure/judge_place.h"
#include "core/closure/known_places.h"
#include "core/closure/scan_location.h"
#include "core/geometry/pose2.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/link_point.h"
#include "core/graph/point_index.h"
#include "core/sensor/record.h"

namespace enfilade::closure {

// The map that the session of the report is in.
struct SessionMap {
  MapId id = {};
  int level = 0;
  Environment environment = Environment::kIndoor;
};

// A place that the robot may have come through: a link point's or a candidate's anchor in the map that the robot would
// be in, with the evidence gathered so far.
struct ComparedPlace {
  const graph::LinkPoint* link_point = nullptr;
  const graph::Anchor* anchor = nullptr;
  PlaceEvidence evidence = {};  // without images and clouds until they have been compared
  bool images_compared = false;
  bool clouds_compared = false;
};

// A link point of the session's own map at the place where the robot went through the door.
struct PassedLinkPoint {
  KnownPlace known;
  ComparedPlace place;  // on its other side
};

// What the graph knows of the passed door in the session's own map.
struct PassedDoor {
  std::vector<PassedLinkPoint> link_points;  // the likeliest first
  std::vector<LinkPointId> sightings;        // candidates that were made when robots saw this door from this map
};

// The scans behind the door against what robots have seen of one map.
struct ScanEvidence {
  ScanLocation location;
  bool recording = false;  // sessions in the map are still recording
  bool mapping = false;    // sessions in the map are recorded, but not mapped yet
};

// A known map on the entered level in which the graph can predict the robot's pose.
struct SearchedMap {
  const graph::MapInGraph* map = nullptr;
  PoseWithCovariance predicted = {};       // T_map_robot
  std::optional<ScanEvidence> scans = {};  // unset: not compared yet
};

// Where odometry alone has a door and the robot behind it, if nothing was mapped there.
struct DoorByOdometry {
  PoseWithCovariance T_map_door = {};
  PoseWithCovariance T_map_robot = {};   // at the time of the report
  PoseWithCovariance T_door_robot = {};  // the same, relative to the door
};

// Where the link points of a graph are in the world by the poses of its maps, so that what is near is found without
// looking at all of them. By slots of the graph.
struct WorldIndex {
  const graph::PointIndex* positions = nullptr;  // m, of link points
  std::vector<int> unplaced_maps = {};           // that have no pose
};

// Everything that is known when a door report is judged, in one value. The first group is set from the start; the
// second one grows step by step, because evidence is expensive: Decide says what it needs next. Places are pointers
// into `graph`, which must outlive them.
struct DoorKnowledge {
  const graph::GraphSnapshot* graph = nullptr;
  std::optional<WorldIndex> world_index = {};  // of `graph`; unset: searches look at all link points
  DoorClosureOptions options = {};
  sensor::DoorReport report = {};
  std::optional<SessionMap> map = {};             // unset: the session was only recorded
  std::optional<std::string> mapping_error = {};  // the session could not be mapped
  // In the session's map; unset: nothing was mapped at the time.
  std::optional<PoseWithCovariance> T_map_door = {};
  std::optional<PoseWithCovariance> T_map_robot = {};   // at the time of the report
  std::optional<PoseWithCovariance> T_door_robot = {};  // the same, relative to the door
  std::optional<DoorByOdometry> by_odometry = {};       // of a passage without these poses
  bool has_views = false;                               // images or clouds were recorded near the door (of a candidate)
  std::vector<Eigen::Vector2d> points_behind_door = {};  // of scans, in the frame of T_map_robot, m
  // Link points that the database refused to promote, or to join to the session's map: another link point joins the
  // same maps at that place already.
  std::set<LinkPointId> redundant = {};
  double waited = 0.0;              // s, for maps that are being mapped
  LinkPointId new_link_point = {};  // ids for what the action makes
  MapId new_map = {};

  // Unset: not searched yet.
  std::optional<PassedDoor> passed = {};
  std::optional<std::vector<ComparedPlace>> places = {};  // of other maps, the nearest first
  std::optional<std::vector<SearchedMap>> maps = {};

  int entered_level() const { return report.entered_level.value_or(map ? map->level : 0); }
};

// Identifies a place in the knowledge.
struct PlaceIndex {
  bool passed = false;  // of passed->link_points, otherwise of places
  std::size_t index = 0;

  friend bool operator==(const PlaceIndex&, const PlaceIndex&) = default;
};
ComparedPlace& PlaceAt(DoorKnowledge& knowledge, const PlaceIndex& index);

// If the robot has come from another level, T_map_door and T_map_robot become less certain in yaw, by
// options.ride_yaw_sigma: a ride turns what SLAM sees of the next level.
void AddRide(DoorKnowledge& knowledge);

}  // namespace enfilade::closure
