// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"

namespace enfilade::sensor {

// How a session's robot came into the map. All unset: the map begins with the session, at the robot's first pose.
struct SessionEntry {
  // Out of this session, which ends with a passage (DoorReport): the verdict on it says which map was entered, and
  // where. Until then the session has no map.
  std::optional<SessionId> previous;
  // Where the robot is in a map that is there already, when odometry says T_odom_robot (unset: at the first scan).
  std::optional<PoseWithCovariance> T_map_robot;
  std::optional<Pose2> T_odom_robot;
};

// The bytes in spools; empty where all is unset.
std::string Encode(const SessionEntry& entry);
// DATA_LOSS on bytes that Encode did not write.
absl::StatusOr<SessionEntry> DecodeSessionEntry(std::string_view bytes);

}  // namespace enfilade::sensor
