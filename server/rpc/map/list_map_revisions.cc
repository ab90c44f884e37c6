// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/paging.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::ListMapRevisionsResponse> ListMapRevisions(const Services& services, const Call& call,
                                                              const v1::ListMapRevisionsRequest& request) {
  v1::ListMapRevisionsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName name, convert::ParseMapName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t before, FromNumericPageToken(request.page_token(), 0));
  ENFILADE_ASSIGN_OR_RETURN(auto revisions,
                            services.revisions.List(call.context(), name.site, name.map, before, size + 1));
  if (CutToPage(revisions, size)) response.set_next_page_token(ToPageToken(std::to_string(revisions.back().number)));
  for (const storage::MapRevision& revision : revisions) *response.add_revisions() = ToProto(revision);
  return response;
}

}  // namespace enfilade::server
