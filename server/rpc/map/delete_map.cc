// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::DeleteMapResponse> DeleteMap(const Services& services, const Call& call,
                                                const v1::DeleteMapRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName name, convert::ParseMapName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.etag()));
  ENFILADE_RETURN_IF_ERROR(services.graph_editor.DeleteMap(call.context(), name.site, name.map, etag, request.force()));
  return v1::DeleteMapResponse();
}

}  // namespace enfilade::server
