// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/paging.h"
#include "server/rpc/session/door_verdict.h"
#include "server/rpc/session/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::ListDoorVerdictsResponse> ListDoorVerdicts(const Services& services, const Call& call,
                                                              const v1::ListDoorVerdictsRequest& request) {
  v1::ListDoorVerdictsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::SessionName name, convert::ParseSessionName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t after, FromNumericPageToken(request.page_token(), 0));
  ENFILADE_ASSIGN_OR_RETURN(auto verdicts,
                            services.door_verdicts.List(call.context(), name.site, name.session, after, size + 1));
  if (CutToPage(verdicts, size)) response.set_next_page_token(ToPageToken(std::to_string(verdicts.back().sequence)));
  for (const closure::DoorVerdict& verdict : verdicts) *response.add_verdicts() = ToProto(name.site, verdict);
  return response;
}

}  // namespace enfilade::server
