// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/robot/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::GetRobotResponse> GetRobot(const Services& services, const Call& call,
                                              const v1::GetRobotRequest& request) {
  v1::GetRobotResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::RobotName name, convert::ParseRobotName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Robot robot, services.robots.Get(call.context(), name.site, name.robot));
  *response.mutable_robot() = ToProto(robot);
  return response;
}

}  // namespace enfilade::server
