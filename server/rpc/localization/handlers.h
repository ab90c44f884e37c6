// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/localization_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"

namespace enfilade::server {

// The RPC of LocalizationService. The proto says what it answers and when it fails.

absl::StatusOr<v1::LocalizeRobotResponse> LocalizeRobot(const Services& services, const Call& call,
                                                        const v1::LocalizeRobotRequest& request);

}  // namespace enfilade::server
