// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/robot_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/call.h"

namespace enfilade::server {

// The unary RPCs of RobotService, one file each. The proto says what they answer and when they fail.

absl::StatusOr<v1::CreateRobotResponse> CreateRobot(const Services& services, const Call& call,
                                                    const v1::CreateRobotRequest& request);
absl::StatusOr<v1::GetRobotResponse> GetRobot(const Services& services, const Call& call,
                                              const v1::GetRobotRequest& request);
absl::StatusOr<v1::ListRobotsResponse> ListRobots(const Services& services, const Call& call,
                                                  const v1::ListRobotsRequest& request);
absl::StatusOr<v1::DeleteRobotResponse> DeleteRobot(const Services& services, const Call& call,
                                                    const v1::DeleteRobotRequest& request);

}  // namespace enfilade::server
