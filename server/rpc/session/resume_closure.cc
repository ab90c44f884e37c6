// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/session/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::ResumeClosureResponse> ResumeClosure(const Services& services, const Call& call,
                                                        const v1::ResumeClosureRequest& request) {
  v1::ResumeClosureResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::LoopClosureName name, convert::ParseLoopClosureName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(
      const slam::LoopClosure closure,
      services.closures.SetSuspended(call.context(), name.site, name.session, name.closure, false));
  services.mapping.Wake();
  *response.mutable_closure() = ToProto({name.site, name.session}, closure);
  return response;
}

}  // namespace enfilade::server
