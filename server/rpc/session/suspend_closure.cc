// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/session/handlers.h"

namespace enfilade::server {
namespace {

template <typename Response, typename Request>
absl::StatusOr<Response> SetClosureSuspended(const Services& services, const Call& call, const Request& request,
                                             bool suspended) {
  Response response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::LoopClosureName name, convert::ParseLoopClosureName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(
      const slam::LoopClosure closure,
      services.closures.SetSuspended(call.context(), name.site, name.session, name.closure, suspended));
  services.mapping.Wake(name.site, name.session);
  *response.mutable_closure() = server::ToProto({name.site, name.session}, closure);
  return response;
}

}  // namespace

absl::StatusOr<v1::SuspendClosureResponse> SuspendClosure(const Services& services, const Call& call,
                                                          const v1::SuspendClosureRequest& request) {
  return SetClosureSuspended<v1::SuspendClosureResponse>(services, call, request, true);
}

absl::StatusOr<v1::ResumeClosureResponse> ResumeClosure(const Services& services, const Call& call,
                                                        const v1::ResumeClosureRequest& request) {
  return SetClosureSuspended<v1::ResumeClosureResponse>(services, call, request, false);
}

}  // namespace enfilade::server
