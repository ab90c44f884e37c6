// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/area/convert.h"
#include "server/rpc/area/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::GetMapAreaResponse> GetMapArea(const Services& services, const Call& call,
                                                  const v1::GetMapAreaRequest& request) {
  v1::GetMapAreaResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapAreaName name, convert::ParseMapAreaName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapArea area,
                            services.map_areas.Get(call.context(), name.site, name.map, name.area));
  *response.mutable_area() = ToProto(area);
  return response;
}

}  // namespace enfilade::server
