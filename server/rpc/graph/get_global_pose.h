// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "absl/status/statusor.h"
#include "core/graph/global_pose.h"
#include "enfilade/v1/graph_service.pb.h"
#include "server/app/services.h"
#include "storage/graph/robot_pose_store.h"

namespace enfilade::server {

// The answer if it needs no database: a pose in a map of a site whose graph is in memory and up to date. Never waits.
std::optional<absl::StatusOr<v1::GetGlobalPoseResponse>> TryGetGlobalPose(const Services& services,
                                                                          const v1::GetGlobalPoseRequest& request);

// A robot's report and where it is in the world at that version of the graph; `pose` is empty if no link points join
// its map to the world.
v1::GlobalPose ToProto(const storage::RobotPose& report, const std::optional<graph::GlobalPose>& pose,
                       std::int64_t graph_version);

}  // namespace enfilade::server
