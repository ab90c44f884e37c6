// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/base/environment.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point.h"

namespace enfilade::rearrange {

using RearrangementId = Id<struct RearrangementTag>;

// A session whose drive covers several rooms is cut: its records from `first_sequence` on, up to its next cut, become
// the session `rest`, a new id. The rest begins in the map of `session`; a SessionMove takes it elsewhere.
struct SessionCut {
  SessionId session = {};
  std::int64_t first_sequence = 0;  // within the log: neither its first record nor behind its last one
  SessionId rest = {};

  friend bool operator==(const SessionCut&, const SessionCut&) = default;
};

// What a session has mapped moves rigidly out of the map that it is in now into the frame of another one, or to another
// place in the same map.
struct SessionMove {
  SessionId session = {};
  MapId to = {};
  Pose2 T_to_from = {};  // m, rad

  friend bool operator==(const SessionMove&, const SessionMove&) = default;
};

// `from` has no session left and disappears; its name leads to `to`. What was in its frame (robots' poses, control
// points, evidence, an imported raster) is transformed.
struct MapRedirect {
  MapId from = {};
  MapId to = {};
  Pose2 T_to_from = {};  // m, rad

  friend bool operator==(const MapRedirect&, const MapRedirect&) = default;
};

// A map that begins. Its display name is `name_prefix` and a free number, the one before which is taken. Its place in
// the world is that of the sessions that move into it.
struct MapSeed {
  MapId id = {};
  std::string name_prefix = {};
  int level = 0;
  Environment environment = Environment::kIndoor;
  std::string slam_profile = {};

  friend bool operator==(const MapSeed&, const MapSeed&) = default;
};

// What is to be done so that a site's maps are its rooms: decided purely, applied in one transaction
// (storage::RearrangementStore), in the order of the members. One session occurs in at most one move, one map in at
// most one redirect, and no redirect leads to a map that is itself redirected here.
struct Rearrangement {
  std::vector<MapSeed> new_maps = {};
  std::vector<SessionCut> cuts = {};
  std::vector<SessionMove> moves = {};
  // New ones, and all anchors of existing ids anew: kind, direction and anchors are stored; what an existing one has
  // beside them (tag, difficulty, state, use) stays.
  std::vector<graph::LinkPoint> link_points = {};
  std::vector<LinkPointId> removed_link_points = {};
  std::vector<MapRedirect> redirects = {};
  std::string reason = {};  // for people: "2 maps of one room: ..."
  // The plan whose door joins two maps: candidates of both become one link point (core/closure/plans/plan_doors.h),
  // which has the evidence of all of them. Empty: none.
  PriorMapId plan = {};

  bool empty() const {
    return new_maps.empty() && cuts.empty() && moves.empty() && link_points.empty() && removed_link_points.empty() &&
           redirects.empty();
  }
};

// INVALID_ARGUMENT naming what breaks a rule above: an id that is invalid or given twice, a cut before the first
// record, a pose that is not finite, something that moves into a map that disappears, a link point that is invalid, or
// both stored and removed.
absl::Status Validate(const Rearrangement& rearrangement);

// T_to_x: what was seen from one frame, seen from another one that is known exactly.
PoseWithCovariance Moved(const Pose2& T_to_from, const PoseWithCovariance& T_from_x);

}  // namespace enfilade::rearrange
