// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/paging.h"
#include "server/rpc/resources.h"
#include "server/rpc/site/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::ListSitesResponse> ListSites(const Services& services, const Call& call,
                                                const v1::ListSitesRequest& request) {
  v1::ListSitesResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::string after, FromPageToken(request.page_token()));
  ENFILADE_ASSIGN_OR_RETURN(auto sites, services.sites.List(call.context(), {size + 1, after}));
  if (CutToPage(sites, size)) response.set_next_page_token(ToPageToken(sites.back().id.value()));
  for (const storage::Site& site : sites) *response.add_sites() = ToProto(site);
  return response;
}

}  // namespace enfilade::server
