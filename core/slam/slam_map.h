// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/pose2.h"

namespace enfilade::slam {

// One session's map as rows, the form in which it is stored. Rows are added, and their poses change when the pose graph
// is solved. Poses are in the map frame: the robot's pose at the first keyframe; or the frame of the existing map,
// which is then submap 0.

// A keyframe.
struct SlamNode {
  std::int64_t id = 0;        // 0, 1, 2, ... in order of time
  std::int64_t sequence = 0;  // of the scan's record in the session's log
  TimeNs time = 0;
  Pose2 T_map_node;  // the robot's pose at the keyframe
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  // of T_map_node, relative to the first node or the existing map
  std::int64_t submap = 0;      // the submap that it was matched in

  friend bool operator==(const SlamNode&, const SlamNode&) = default;
};

struct SlamSubmap {
  std::int64_t id = 0;       // 0, 1, 2, ...
  std::int64_t version = 0;  // counts the changes of its content
  Pose2 T_map_submap;
  bool finished = false;
  // The content (grid, poses of keyframes), compressed, in the submap's frame. Empty until the submap is finished.
  std::string content;

  friend bool operator==(const SlamSubmap&, const SlamSubmap&) = default;
};

enum class LoopClosureState : std::int16_t { kAccepted = 1, kRejected = 2, kSuspended = 3 };

// A loop closure that was tried: `node` recognised in `submap`, or not.
struct LoopClosure {
  std::int64_t id = 0;
  std::int64_t submap = 0;
  std::int64_t node = 0;
  Pose2 T_submap_node;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  LoopClosureState state = LoopClosureState::kRejected;
  double score = 0.0;  // share of inlier beams at the finest level, 0..1
  double chi2 = 0.0;   // of the edge after the last solution; 0 if it was not in the graph
  std::string reason;  // for people, such as "inlier share 0.31 below 0.45 at 0.2 m"

  friend bool operator==(const LoopClosure&, const LoopClosure&) = default;
};

// The robot's pose at one scan, keyframe or not. It is relative to a node, so that it follows when nodes move.
struct TrajectoryPoint {
  std::int64_t sequence = 0;
  TimeNs time = 0;
  std::int64_t node = 0;
  Pose2 T_node_robot;

  friend bool operator==(const TrajectoryPoint&, const TrajectoryPoint&) = default;
};

// The rows added or changed since the last delta, each as a whole.
struct SlamDelta {
  std::vector<SlamNode> nodes;
  std::vector<SlamSubmap> submaps;  // `content` is empty if unchanged
  std::vector<LoopClosure> loop_closures;
  std::vector<TrajectoryPoint> trajectory;  // appended only

  bool empty() const { return nodes.empty() && submaps.empty() && loop_closures.empty() && trajectory.empty(); }
};

// The sum of all deltas.
struct SlamMap {
  std::map<std::int64_t, SlamNode> nodes;
  std::map<std::int64_t, SlamSubmap> submaps;
  std::map<std::int64_t, LoopClosure> loop_closures;
  std::vector<TrajectoryPoint> trajectory;

  void Apply(SlamDelta delta);
};

struct StampedPose {
  TimeNs time = 0;
  Pose2 T_map_robot;
};

// Every used scan's pose by the current estimate, in the order of the log.
std::vector<StampedPose> TrajectoryOf(const std::map<std::int64_t, SlamNode>& nodes,
                                      const std::vector<TrajectoryPoint>& trajectory);
std::vector<StampedPose> TrajectoryOf(const SlamMap& map);

}  // namespace enfilade::slam
