// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/robot/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::DeleteRobotResponse> DeleteRobot(const Services& services, const Call& call,
                                                    const v1::DeleteRobotRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::RobotName name, convert::ParseRobotName("name", request.name()));
  ENFILADE_RETURN_IF_ERROR(services.robots.Delete(call.context(), name.site, name.robot, /*etag=*/0));
  return v1::DeleteRobotResponse();
}

}  // namespace enfilade::server
