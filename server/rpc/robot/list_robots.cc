// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/paging.h"
#include "server/rpc/resources.h"
#include "server/rpc/robot/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::ListRobotsResponse> ListRobots(const Services& services, const Call& call,
                                                  const v1::ListRobotsRequest& request) {
  v1::ListRobotsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::string after, FromPageToken(request.page_token()));
  ENFILADE_ASSIGN_OR_RETURN(auto robots, services.robots.List(call.context(), site, {size + 1, after}));
  if (CutToPage(robots, size)) response.set_next_page_token(ToPageToken(robots.back().id.value()));
  for (const storage::Robot& robot : robots) *response.add_robots() = ToProto(robot);
  return response;
}

}  // namespace enfilade::server
