// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/session/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::FinishSessionResponse> FinishSession(const Services& services, const Call& call,
                                                        const v1::FinishSessionRequest& request) {
  v1::FinishSessionResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::SessionName name, convert::ParseSessionName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Session session,
                            services.sessions.Finish(call.context(), name.site, name.session, request.last_sequence()));
  services.mapping.Wake(name.site, name.session);
  *response.mutable_session() = ToProto(session);
  return response;
}

}  // namespace enfilade::server
