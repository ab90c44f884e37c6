// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/paging.h"
#include "server/rpc/prior/convert.h"
#include "server/rpc/prior/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::ListPriorMapsResponse> ListPriorMaps(const Services& services, const Call& call,
                                                        const v1::ListPriorMapsRequest& request) {
  v1::ListPriorMapsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::string after, FromPageToken(request.page_token()));
  ENFILADE_ASSIGN_OR_RETURN(auto prior_maps, services.prior_maps.List(call.context(), site, {size + 1, after}));
  if (CutToPage(prior_maps, size)) response.set_next_page_token(ToPageToken(prior_maps.back().id.value()));
  for (const storage::PriorMap& prior_map : prior_maps) *response.add_prior_maps() = ToProto(prior_map);
  return response;
}

}  // namespace enfilade::server
