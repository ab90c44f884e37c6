// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/session/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::DeleteSessionResponse> DeleteSession(const Services& services, const Call& call,
                                                        const v1::DeleteSessionRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::SessionName name, convert::ParseSessionName("name", request.name()));
  ENFILADE_RETURN_IF_ERROR(services.sessions.Delete(call.context(), name.site, name.session));
  return v1::DeleteSessionResponse();
}

}  // namespace enfilade::server
