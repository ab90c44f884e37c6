// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/site/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::CreateSiteResponse> CreateSite(const Services& services, const Call& call,
                                                  const v1::CreateSiteRequest& request) {
  v1::CreateSiteResponse response;
  ENFILADE_ASSIGN_OR_RETURN(storage::Site site, FromProto(request.site()));
  ENFILADE_ASSIGN_OR_RETURN(std::string id, IdOrNew("site_id", request.site_id()));
  site.id = SiteId(std::move(id));
  ENFILADE_ASSIGN_OR_RETURN(const storage::RequestId request_id, RequestIdOf(request));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Site created, services.sites.Create(call.context(), site, request_id));
  *response.mutable_site() = ToProto(created);
  return response;
}

}  // namespace enfilade::server
