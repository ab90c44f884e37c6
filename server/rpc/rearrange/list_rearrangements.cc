// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/paging.h"
#include "server/rpc/rearrange/handlers.h"
#include "server/rpc/rearrange/messages.h"

namespace enfilade::server {

absl::StatusOr<v1::ListRearrangementsResponse> ListRearrangements(const Services& services, const Call& call,
                                                                  const v1::ListRearrangementsRequest& request) {
  v1::ListRearrangementsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t before, FromNumericPageToken(request.page_token(), 0));
  ENFILADE_RETURN_IF_ERROR(services.sites.Get(call.context(), site).status());
  ENFILADE_ASSIGN_OR_RETURN(auto listed, services.rearrangement_store.List(call.context(), site, before, size + 1));
  if (CutToPage(listed, size)) response.set_next_page_token(ToPageToken(std::to_string(listed.back().version_after)));
  for (const storage::StoredRearrangement& rearrangement : listed) {
    *response.add_rearrangements() = ToProto(rearrangement);
  }
  return response;
}

}  // namespace enfilade::server
