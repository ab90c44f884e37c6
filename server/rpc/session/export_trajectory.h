// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/session_service.pb.h"
#include "server/rpc/server_stream.h"

namespace enfilade::server {

// SessionService.ExportTrajectory.
absl::StatusOr<MessageSource<v1::ExportTrajectoryResponse>> ExportTrajectory(
    const Services& services, const storage::CallContext& context, const v1::ExportTrajectoryRequest& request);

}  // namespace enfilade::server
