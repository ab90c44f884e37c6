// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/site/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::UpdateSiteResponse> UpdateSite(const Services& services, const Call& call,
                                                  const v1::UpdateSiteRequest& request) {
  v1::UpdateSiteResponse response;
  const auto& mask = request.update_mask();
  ENFILADE_RETURN_IF_ERROR(CheckMask(mask, {"display_name", "raw_retention"}));
  ENFILADE_ASSIGN_OR_RETURN(const SiteId id, convert::ParseSiteName("site.name", request.site().name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.site().etag()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Site stored, services.sites.Get(call.context(), id));

  v1::Site changed = ToProto(stored);
  if (IsUpdated(mask, "display_name", !request.site().display_name().empty())) {
    changed.set_display_name(request.site().display_name());
  }
  if (IsUpdated(mask, "raw_retention", request.site().has_raw_retention())) {
    changed.clear_raw_retention();
    if (request.site().has_raw_retention()) *changed.mutable_raw_retention() = request.site().raw_retention();
  }
  ENFILADE_ASSIGN_OR_RETURN(storage::Site site, FromProto(changed));
  site.id = id;
  site.etag = etag != 0 ? etag : stored.etag;
  ENFILADE_ASSIGN_OR_RETURN(const storage::Site updated, services.sites.Update(call.context(), site));
  *response.mutable_site() = ToProto(updated);
  return response;
}

}  // namespace enfilade::server
