// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/paging.h"
#include "server/rpc/resources.h"
#include "server/rpc/session/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::ListClosuresResponse> ListClosures(const Services& services, const Call& call,
                                                      const v1::ListClosuresRequest& request) {
  v1::ListClosuresResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::SessionName name, convert::ParseSessionName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t after, FromNumericPageToken(request.page_token(), -1));
  ENFILADE_ASSIGN_OR_RETURN(auto closures,
                            services.closures.List(call.context(), name.site, name.session, after, size + 1));
  if (CutToPage(closures, size)) response.set_next_page_token(ToPageToken(std::to_string(closures.back().id)));
  for (const slam::LoopClosure& closure : closures) *response.add_closures() = ToProto(name, closure);
  return response;
}

}  // namespace enfilade::server
