// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::CreateMapResponse> CreateMap(const Services& services, const Call& call,
                                                const v1::CreateMapRequest& request) {
  v1::CreateMapResponse response;
  ENFILADE_ASSIGN_OR_RETURN(storage::Map map, FromProto(request.map()));
  ENFILADE_ASSIGN_OR_RETURN(map.site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(std::string id, IdOrNew("map_id", request.map_id()));
  map.id = MapId(std::move(id));
  ENFILADE_ASSIGN_OR_RETURN(const storage::RequestId request_id, RequestIdOf(request));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map created,
                            services.graph_editor.CreateMap(call.context(), map, request_id));
  *response.mutable_map() = ToProto(created);
  return response;
}

}  // namespace enfilade::server
