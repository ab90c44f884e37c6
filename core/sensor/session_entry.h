// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"

namespace enfilade::sensor {

// How a session's robot entered the map. All unset: the map starts with the session, at the robot's first pose, or, if
// it has content already, the robot is located in it by its scans.
struct SessionEntry {
  // The session that the robot left through a door (DoorReport::Kind::kPassage). The verdict on that passage gives the
  // map and the pose in it; until then the session has no map.
  std::optional<SessionId> previous;
  // The robot's pose in an existing map when its odometry reads T_odom_robot (unset: at the first scan).
  std::optional<PoseWithCovariance> T_map_robot;
  std::optional<Pose2> T_odom_robot;
};

// The bytes in spools; empty if all fields are unset.
std::string Encode(const SessionEntry& entry);
// DATA_LOSS on bytes that Encode did not write.
absl::StatusOr<SessionEntry> DecodeSessionEntry(std::string_view bytes);

}  // namespace enfilade::sensor
