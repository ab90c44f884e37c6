// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/map/map_alias_message.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::SetMapAliasResponse> SetMapAlias(const Services& services, const Call& call,
                                                    const v1::SetMapAliasRequest& request) {
  const v1::MapAlias& wanted = request.alias();
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapAliasName name, convert::ParseMapAliasName("alias.name", wanted.name()));
  ENFILADE_ASSIGN_OR_RETURN(const convert::RevisionName revision,
                            convert::ParseRevisionName("alias.revision", wanted.revision()));
  if (revision.site != name.site || revision.map != name.map) {
    return InvalidArgument("alias.revision is \"{}\": expected a revision of {}", wanted.revision(),
                           convert::NameOf(convert::MapName{name.site, name.map}));
  }
  storage::MapAlias alias{.site = name.site, .map = name.map, .id = name.alias, .revision = revision.revision};
  ENFILADE_ASSIGN_OR_RETURN(alias.etag, ParseEtag(wanted.etag()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapAlias set, services.map_aliases.Set(call.context(), alias));
  v1::SetMapAliasResponse response;
  *response.mutable_alias() = ToProto(set);
  return response;
}

}  // namespace enfilade::server
