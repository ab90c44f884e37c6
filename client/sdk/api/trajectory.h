// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "client/sdk/connection.h"
#include "enfilade/v1/session_service.pb.h"

namespace enfilade::client {

// Calls `take` for the pose of every mapped scan of a session, in the order of time, and returns how many there were.
// `session`: sites/{site}/sessions/{session}. An error of `take` ends the export with it. Errors as
// SessionService.ExportTrajectory.
absl::StatusOr<std::int64_t> ExportTrajectory(const Connection& connection, const std::string& session,
                                              const std::function<absl::Status(const v1::TrajectoryPose&)>& take);

}  // namespace enfilade::client
