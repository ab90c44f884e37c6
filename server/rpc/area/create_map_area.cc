// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/area/convert.h"
#include "server/rpc/area/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::CreateMapAreaResponse> CreateMapArea(const Services& services, const Call& call,
                                                        const v1::CreateMapAreaRequest& request) {
  v1::CreateMapAreaResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName parent, convert::ParseMapName("parent", request.parent()));
  storage::MapArea area;
  area.site = parent.site;
  area.map = parent.map;
  ENFILADE_ASSIGN_OR_RETURN(area.area, FromProto(request.area()));
  ENFILADE_ASSIGN_OR_RETURN(std::string id, IdOrNew("area_id", request.area_id()));
  area.id = MapAreaId(std::move(id));
  ENFILADE_ASSIGN_OR_RETURN(const storage::RequestId request_id, RequestIdOf(request));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapArea created,
                            services.map_areas.Create(call.context(), area, request_id, request.force()));
  if (created.area.kind == areas::AreaKind::kIgnoreHits) {
    ENFILADE_RETURN_IF_ERROR(services.map_edits.Recompose(call.context(), {created.site, created.map}));
  }
  *response.mutable_area() = ToProto(created);
  return response;
}

}  // namespace enfilade::server
