// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/paging.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::ListMapsResponse> ListMaps(const Services& services, const Call& call,
                                              const v1::ListMapsRequest& request) {
  v1::ListMapsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  if (!request.display_name().empty()) {
    const auto map = services.maps.GetByDisplayName(call.context(), site, request.display_name());
    if (map.ok()) *response.add_maps() = ToProto(*map);
    if (!map.ok() && !absl::IsNotFound(map.status())) return map.status();
    return response;
  }
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::string after, FromPageToken(request.page_token()));
  ENFILADE_ASSIGN_OR_RETURN(auto maps, services.maps.List(call.context(), site, {size + 1, after}));
  if (CutToPage(maps, size)) response.set_next_page_token(ToPageToken(maps.back().id.value()));
  for (const storage::Map& map : maps) *response.add_maps() = ToProto(map);
  return response;
}

}  // namespace enfilade::server
