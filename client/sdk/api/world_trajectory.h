// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/sdk/connection.h"
#include "core/base/time.h"
#include "core/geometry/pose2.h"

namespace enfilade::client {

struct MappedPose {
  TimeNs time = 0;
  Pose2 T_map_robot;
};

// One session's part of a robot's way.
struct MappedStretch {
  std::string session;               // sites/{site}/sessions/{session}
  std::string map;                   // sites/{site}/maps/{map}; empty: the session is in no map (yet)
  std::string map_name;              // its display name
  std::optional<Pose2> T_world_map;  // unset: no link points join the map to the root
  std::vector<MappedPose> poses;     // by time
};

// The sessions of a robot that have mapped scans or are in no map, the earliest first. `robot`: sites/{site}/robots/
// {robot}. Everything is read at one version of the graph: if it changes meanwhile, everything is read again, at most
// five times. NOT_FOUND: the robot has no sessions. ABORTED: the graph changed each time.
absl::StatusOr<std::vector<MappedStretch>> ReadStretches(const Connection& connection, const std::string& robot);

// The sessions of all robots of a site, `site`: sites/{site}, as they are while they are read: not at one version of
// the graph. For pictures. Empty if there are none.
absl::StatusOr<std::vector<MappedStretch>> ReadPresentStretches(const Connection& connection, const std::string& site);

struct WorldPose {
  TimeNs time = 0;
  Pose2 T_world_robot;
};

struct WorldTrajectory {
  std::vector<WorldPose> poses;  // by time; no time twice
  // What has no place in the world.
  std::vector<MappedStretch> left_out;
};

// All stretches in the world frame. Of poses at the same time, that of the earlier stretch stays.
WorldTrajectory JoinStretches(const std::vector<MappedStretch>& stretches);

}  // namespace enfilade::client
