// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/site/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::DeleteSiteResponse> DeleteSite(const Services& services, const Call& call,
                                                  const v1::DeleteSiteRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const SiteId id, convert::ParseSiteName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.etag()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Site deleted,
                            services.site_deletions.Begin(call.context(), id, etag, request.force()));
  v1::DeleteSiteResponse response;
  *response.mutable_site() = ToProto(deleted);
  return response;
}

}  // namespace enfilade::server
