// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/site/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::GetSiteResponse> GetSite(const Services& services, const Call& call,
                                            const v1::GetSiteRequest& request) {
  v1::GetSiteResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId id, convert::ParseSiteName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Site site, services.sites.Get(call.context(), id));
  *response.mutable_site() = ToProto(site);
  return response;
}

}  // namespace enfilade::server
