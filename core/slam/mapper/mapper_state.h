// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/slam/mapper/existing_map.h"
#include "core/slam/mapper/motion_model.h"
#include "core/slam/mapper/policies.h"
#include "core/slam/slam_map.h"
#include "core/slam/submaps/submap.h"

namespace enfilade::slam {

// A submap that gets no more scans: compressed, with what the pose graph needs of it beside.
struct FinishedSubmap {
  Pose2 T_map_submap;
  std::int64_t version = 0;
  std::string content;  // Encode(SubmapContent)
  std::vector<SubmapNode> nodes;
  std::optional<NextSubmap> next;
  double length = 0.0;  // m driven in it
  double extent = 0.0;  // m, from its origin to its farthest keyframe
  // Of the old map that mapping goes on in, which has no keyframes: the box of what it knows, m; else empty.
  Eigen::AlignedBox2d known;
};

FinishedSubmap Finished(const Pose2& T_map_submap, std::int64_t version, std::string content,
                        const std::vector<SubmapNode>& nodes, const std::optional<NextSubmap>& next);

// The old map as submap 0; `next` is not known before the first scan.
FinishedSubmap FinishedExistingMap(std::int64_t version, const SubmapContent& content);

// Where the robot is, relative to the active submap.
struct Track {
  Pose2 T_submap_robot;
  std::optional<Pose2> T_odom_robot;   // at the same scan
  TimeNs time = 0;                     // of it
  TimeNs matched_at = 0;               // the time of the last scan that matched well
  std::optional<Step> last_step;       // the one that led here
  double length_since_keyframe = 0.0;  // m
  TrackQuality quality;
};

// All that a mapper knows.
struct MapperState {
  std::optional<ExistingMapEntry> entry;  // mapping goes on in an old map, which is submap 0
  std::optional<Submap> active;
  std::optional<Track> track;
  std::map<std::int64_t, FinishedSubmap> finished;
  std::map<std::int64_t, SlamNode> nodes;
  std::map<std::int64_t, LoopClosure> closures;
  // Which submaps accepted closures join, both ways: follows from `closures` and is kept to spare going through them.
  std::map<std::int64_t, std::set<std::int64_t>> joined;
  bool ended = false;  // Finish was called
  // When the graph was last solved, and what has come since.
  std::int64_t nodes_at_solve = 0;
  bool unsolved_closures = false;
  bool urgent_closures = false;  // among them some that the estimate fits badly
  // The submap that was begun because the robot was lost, until a closure joins what followed to what was before.
  std::optional<std::int64_t> adrift_since;

  std::int64_t last_submap() const { return active ? active->id : static_cast<std::int64_t>(finished.size()) - 1; }
  bool is_existing_map(std::int64_t submap) const { return entry.has_value() && submap == 0; }
};

// Whether an accepted closure joins a keyframe of submap `since` or later to a submap before it, or the other way
// round.
bool IsRecognised(const MapperState& state, std::int64_t since);

// Takes note in `joined` of one closure, if it is accepted, or of all anew, after some have changed.
void Join(const LoopClosure& closure, MapperState& state);
void JoinAll(MapperState& state);

// Bytes of memory held by what has to be kept of the way so far: all but the active submap. Grows with the way.
std::size_t KeptBytes(const MapperState& state);

// The part of `state` that is not in rows.
std::string EncodeCheckpoint(const MapperState& state);

// DATA_LOSS where the two do not belong together.
absl::StatusOr<MapperState> DecodeCheckpoint(std::string_view checkpoint, const SlamMap& stored,
                                             const OccupancyOptions& options);

}  // namespace enfilade::slam
