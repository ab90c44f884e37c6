// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::DeleteMapAliasResponse> DeleteMapAlias(const Services& services, const Call& call,
                                                          const v1::DeleteMapAliasRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapAliasName name, convert::ParseMapAliasName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.etag()));
  ENFILADE_RETURN_IF_ERROR(services.map_aliases.Delete(call.context(), name.site, name.map, name.alias, etag));
  return v1::DeleteMapAliasResponse();
}

}  // namespace enfilade::server
