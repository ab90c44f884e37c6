// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/map/map_alias_message.h"

namespace enfilade::server {

absl::StatusOr<v1::ListMapAliasesResponse> ListMapAliases(const Services& services, const Call& call,
                                                          const v1::ListMapAliasesRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName name, convert::ParseMapName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const auto aliases, services.map_aliases.List(call.context(), name.site, name.map));
  v1::ListMapAliasesResponse response;
  for (const storage::MapAlias& alias : aliases) *response.add_aliases() = ToProto(alias);
  return response;
}

}  // namespace enfilade::server
