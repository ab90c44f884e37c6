// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/link_point/convert.h"
#include "server/rpc/link_point/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
namespace {

template <typename Response, typename Request>
absl::StatusOr<Response> SetSuspended(const Services& services, const Call& call, const Request& request,
                                      bool suspended) {
  Response response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::LinkPointName name, convert::ParseLinkPointName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.etag()));
  ENFILADE_ASSIGN_OR_RETURN(
      const storage::StoredLinkPoint changed,
      services.graph_editor.SetSuspended(call.context(), name.site, name.link_point, etag, suspended));
  ENFILADE_ASSIGN_OR_RETURN(*response.mutable_link_point(), WithEvidence(services, call.context(), changed));
  return response;
}

}  // namespace

absl::StatusOr<v1::SuspendLinkPointResponse> SuspendLinkPoint(const Services& services, const Call& call,
                                                              const v1::SuspendLinkPointRequest& request) {
  return SetSuspended<v1::SuspendLinkPointResponse>(services, call, request, true);
}

absl::StatusOr<v1::ResumeLinkPointResponse> ResumeLinkPoint(const Services& services, const Call& call,
                                                            const v1::ResumeLinkPointRequest& request) {
  return SetSuspended<v1::ResumeLinkPointResponse>(services, call, request, false);
}

}  // namespace enfilade::server
