// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/graph/global_pose.h"
#include "server/app/graph/site_graph.h"
#include "storage/graph/robot_pose_store.h"

namespace enfilade::server {

// Finds the poses of robots in the world that a watcher has not seen yet. Not thread-safe.
class PoseUpdates {
 public:
  // How far a watcher has seen; a later watch resumes from it.
  struct Position {
    std::int64_t graph_version = 0;
    std::int64_t report_version = 0;  // the greatest

    friend bool operator==(const Position&, const Position&) = default;
  };
  struct Update {
    storage::RobotPose report;
    std::optional<graph::GlobalPose> pose;  // empty: no link points join the robot's map to the world
  };

  // Of `robots` only; empty: of all.
  PoseUpdates(const Position& resumed, std::set<RobotId> robots);

  // The robots that have reported again or that the graph has moved since the last call. In the first call: all but
  // those whose report and graph version are within the position resumed from.
  absl::StatusOr<std::vector<Update>> Next(const SiteGraph& graph, const std::vector<storage::RobotPose>& reports);

  // After the last call of Next().
  const Position& position() const { return position_; }

 private:
  struct Seen {
    std::int64_t report_version = 0;
    std::optional<PoseWithCovariance> T_world_robot;
  };

  bool IsNew(const storage::RobotPose& report, std::int64_t graph_version,
             const std::optional<graph::GlobalPose>& pose);

  const Position resumed_;
  const std::set<RobotId> robots_;
  Position position_;
  std::map<RobotId, Seen> seen_;
};

}  // namespace enfilade::server
