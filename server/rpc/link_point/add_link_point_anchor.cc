// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/link_point/convert.h"
#include "server/rpc/link_point/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::AddLinkPointAnchorResponse> AddLinkPointAnchor(const Services& services, const Call& call,
                                                                  const v1::AddLinkPointAnchorRequest& request) {
  v1::AddLinkPointAnchorResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::LinkPointName name, convert::ParseLinkPointName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.etag()));
  ENFILADE_ASSIGN_OR_RETURN(const graph::Anchor anchor, FromProto("anchor", name.site, request.anchor()));
  ENFILADE_ASSIGN_OR_RETURN(
      const storage::StoredLinkPoint changed,
      services.graph_editor.AddAnchor(call.context(), name.site, {name.link_point, etag, anchor, request.force()}));
  ENFILADE_ASSIGN_OR_RETURN(*response.mutable_link_point(), WithEvidence(services, call.context(), changed));
  return response;
}

}  // namespace enfilade::server
