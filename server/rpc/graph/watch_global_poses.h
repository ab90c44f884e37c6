// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/graph_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/watch_stream.h"

namespace enfilade::server {

// GraphService.WatchGlobalPoses.
absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>> WatchGlobalPoses(const Services& services, const Call& call,
                                                                     const v1::WatchGlobalPosesRequest& request);

}  // namespace enfilade::server
