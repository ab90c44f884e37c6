// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/robot/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::CreateRobotResponse> CreateRobot(const Services& services, const Call& call,
                                                    const v1::CreateRobotRequest& request) {
  v1::CreateRobotResponse response;
  ENFILADE_ASSIGN_OR_RETURN(storage::Robot robot, FromProto(request.robot()));
  ENFILADE_ASSIGN_OR_RETURN(robot.site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(std::string id, IdOrNew("robot_id", request.robot_id()));
  robot.id = RobotId(std::move(id));
  ENFILADE_ASSIGN_OR_RETURN(const storage::RequestId request_id, RequestIdOf(request));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Robot created, services.robots.Create(call.context(), robot, request_id));
  *response.mutable_robot() = ToProto(created);
  return response;
}

}  // namespace enfilade::server
