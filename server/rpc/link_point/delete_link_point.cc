// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/link_point/convert.h"
#include "server/rpc/link_point/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::DeleteLinkPointResponse> DeleteLinkPoint(const Services& services, const Call& call,
                                                            const v1::DeleteLinkPointRequest& request) {
  v1::DeleteLinkPointResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::LinkPointName name, convert::ParseLinkPointName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.etag()));
  ENFILADE_RETURN_IF_ERROR(services.graph_editor.DeleteLinkPoint(call.context(), name.site, name.link_point, etag));
  return response;
}

}  // namespace enfilade::server
