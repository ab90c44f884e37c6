// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/server_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"

namespace enfilade::server {

// The unary RPCs of ServerService, one file each. The proto says what they answer and when they fail.

absl::StatusOr<v1::GetServerStatusResponse> GetServerStatus(const Services& services, const Call& call,
                                                            const v1::GetServerStatusRequest& request);

}  // namespace enfilade::server
