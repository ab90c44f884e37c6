// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/area/convert.h"
#include "server/rpc/area/handlers.h"
#include "server/rpc/paging.h"

namespace enfilade::server {

absl::StatusOr<v1::ListMapAreasResponse> ListMapAreas(const Services& services, const Call& call,
                                                      const v1::ListMapAreasRequest& request) {
  v1::ListMapAreasResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName parent, convert::ParseMapName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::string after, FromPageToken(request.page_token()));
  ENFILADE_ASSIGN_OR_RETURN(auto areas,
                            services.map_areas.List(call.context(), parent.site, parent.map, {size + 1, after}));
  if (CutToPage(areas, size)) response.set_next_page_token(ToPageToken(areas.back().id.value()));
  for (const storage::MapArea& area : areas) *response.add_areas() = ToProto(area);
  return response;
}

}  // namespace enfilade::server
