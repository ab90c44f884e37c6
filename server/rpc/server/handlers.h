// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/server_service.pb.h"
#include "server/app/services.h"
#include "storage/call_context.h"

namespace enfilade::server {

// The unary RPCs of ServerService, one file each. What they answer and when they fail is told in the proto.

absl::StatusOr<v1::GetServerStatusResponse> GetServerStatus(const Services& services,
                                                            const storage::CallContext& context,
                                                            const v1::GetServerStatusRequest& request);

}  // namespace enfilade::server
