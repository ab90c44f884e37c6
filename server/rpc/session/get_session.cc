// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/session/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::GetSessionResponse> GetSession(const Services& services, const Call& call,
                                                  const v1::GetSessionRequest& request) {
  v1::GetSessionResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::SessionName name, convert::ParseSessionName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Session session,
                            services.sessions.Get(call.context(), name.site, name.session));
  *response.mutable_session() = ToProto(session);
  return response;
}

}  // namespace enfilade::server
