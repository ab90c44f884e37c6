// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/area/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::DeleteMapAreaResponse> DeleteMapArea(const Services& services, const Call& call,
                                                        const v1::DeleteMapAreaRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapAreaName name, convert::ParseMapAreaName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.etag()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapArea area,
                            services.map_areas.Get(call.context(), name.site, name.map, name.area));
  ENFILADE_RETURN_IF_ERROR(services.map_areas.Delete(call.context(), name.site, name.map, name.area, etag));
  if (area.area.kind == areas::AreaKind::kIgnoreHits) {
    ENFILADE_RETURN_IF_ERROR(services.map_edits.Recompose(call.context(), {name.site, name.map}));
  }
  return v1::DeleteMapAreaResponse();
}

}  // namespace enfilade::server
