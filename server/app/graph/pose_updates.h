// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
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

// The poses of a site's robots in the world at one moment. Immutable: all who watch the site share it.
struct SitePoses {
  struct OfRobot {
    storage::RobotPose report;
    std::optional<graph::GlobalPose> pose;  // empty: no link points join the robot's map to the world
    bool in_graph = true;                   // false: its map is newer than the graph, and a later moment has its pose
    std::uint64_t changed = 0;              // the last moment at which the robot had reported again or was moved
  };

  std::uint64_t moment = 0;  // counted since the first
  std::shared_ptr<const SiteGraph> graph;
  std::vector<OfRobot> robots;  // by robot

  std::int64_t graph_version() const { return graph->graph().version(); }
};

// The moment after `before` (null: none): `before` itself if nothing has changed.
absl::StatusOr<std::shared_ptr<const SitePoses>> Following(const std::shared_ptr<const SitePoses>& before,
                                                           const std::shared_ptr<const SiteGraph>& graph,
                                                           std::vector<storage::RobotPose> reports);

// Finds the poses of robots in the world that a watcher has not seen yet. Not thread-safe.
class PoseUpdates {
 public:
  // How far a watcher has seen; a later watch resumes from it.
  struct Position {
    std::int64_t graph_version = 0;
    std::int64_t report_version = 0;  // the greatest

    friend bool operator==(const Position&, const Position&) = default;
  };

  // Of `robots` only; empty: of all.
  PoseUpdates(const Position& resumed, std::set<RobotId> robots);

  // The robots that have reported again or that the graph has moved since the last call. In the first call: all but
  // those whose report and graph version are within the position resumed from. `poses` follow those of the last call.
  std::vector<const SitePoses::OfRobot*> Next(const SitePoses& poses);

  // After the last call of Next().
  const Position& position() const { return position_; }

 private:
  const Position resumed_;
  const std::set<RobotId> robots_;
  Position position_;
  std::optional<std::uint64_t> seen_;  // the moment of the last call
};

}  // namespace enfilade::server
