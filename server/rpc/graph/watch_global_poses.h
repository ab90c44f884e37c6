// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "enfilade/v1/graph_service.pb.h"
#include "server/app/graph/pose_updates.h"
#include "server/app/services.h"
#include "server/rpc/call/watch_stream.h"

namespace enfilade::server {

// GraphService.WatchGlobalPoses.
absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>> WatchGlobalPoses(const Services& services, const Call& call,
                                                                     const v1::WatchGlobalPosesRequest& request);

// How far a watch has come, for its client: two numbers with a dash between them. Empty: nothing was seen.
std::string ToResumeToken(const PoseUpdates::Position& position);
// INVALID_ARGUMENT if ToResumeToken() did not make it.
absl::StatusOr<PoseUpdates::Position> FromResumeToken(const std::string& token);

}  // namespace enfilade::server
