// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/graph/handlers.h"
#include "server/rpc/graph/messages.h"
#include "server/rpc/paging.h"

namespace enfilade::server {

absl::StatusOr<v1::ListGraphVersionsResponse> ListGraphVersions(const Services& services, const Call& call,
                                                                const v1::ListGraphVersionsRequest& request) {
  v1::ListGraphVersionsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t before, FromNumericPageToken(request.page_token(), 0));
  ENFILADE_RETURN_IF_ERROR(services.sites.Get(call.context(), site).status());
  ENFILADE_ASSIGN_OR_RETURN(auto versions, services.graph_store.ListVersions(call.context(), site, before, size + 1));
  if (CutToPage(versions, size)) response.set_next_page_token(ToPageToken(std::to_string(versions.back().version)));
  for (const storage::GraphVersion& version : versions) *response.add_graph_versions() = ToProto(site, version);
  return response;
}

}  // namespace enfilade::server
