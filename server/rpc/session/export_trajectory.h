// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/session_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/server_stream.h"

namespace enfilade::server {

// SessionService.ExportTrajectory.
absl::StatusOr<MessageSource<v1::ExportTrajectoryResponse>> ExportTrajectory(
    const Services& services, const Call& call, const v1::ExportTrajectoryRequest& request);

}  // namespace enfilade::server
