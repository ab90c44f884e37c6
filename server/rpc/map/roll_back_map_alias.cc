// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/map/map_alias_message.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::RollBackMapAliasResponse> RollBackMapAlias(const Services& services, const Call& call,
                                                              const v1::RollBackMapAliasRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapAliasName name, convert::ParseMapAliasName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.etag()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapAlias alias,
                            services.map_aliases.RollBack(call.context(), name.site, name.map, name.alias, etag));
  v1::RollBackMapAliasResponse response;
  *response.mutable_alias() = ToProto(alias);
  return response;
}

}  // namespace enfilade::server
