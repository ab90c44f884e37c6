// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::GetMapResponse> GetMap(const Services& services, const Call& call,
                                          const v1::GetMapRequest& request) {
  v1::GetMapResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName name, convert::ParseMapName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map map, services.maps.Get(call.context(), name.site, name.map));
  *response.mutable_map() = ToProto(map);
  return response;
}

}  // namespace enfilade::server
