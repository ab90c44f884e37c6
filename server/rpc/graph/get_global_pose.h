// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "enfilade/v1/graph_service.pb.h"
#include "server/app/services.h"
#include "storage/robot_pose_store.h"

namespace enfilade::server {

// The answer where it needs no database: a pose in a map of a site whose graph is in memory and up to date. Never
// waits.
std::optional<absl::StatusOr<v1::GetGlobalPoseResponse>> TryGetGlobalPose(const Services& services,
                                                                          const v1::GetGlobalPoseRequest& request);

// The robot's last report in the world.
absl::StatusOr<v1::GlobalPose> GlobalPoseOf(const SiteGraph& graph, const storage::RobotPose& report);

}  // namespace enfilade::server
