// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/map/map_alias_message.h"

#include <string>

#include "proto/convert/names.h"
#include "proto/convert/record.h"

namespace enfilade::server {

v1::MapAlias ToProto(const storage::MapAlias& alias) {
  v1::MapAlias out;
  out.set_name(convert::NameOf(convert::MapAliasName{alias.site, alias.map, alias.id}));
  out.set_revision(convert::NameOf(convert::RevisionName{alias.site, alias.map, alias.revision}));
  if (alias.previous_revision > 0) {
    out.set_previous_revision(convert::NameOf(convert::RevisionName{alias.site, alias.map, alias.previous_revision}));
  }
  out.set_etag(std::to_string(alias.etag));
  out.set_actor(alias.actor);
  *out.mutable_update_time() = convert::ToTimestamp(alias.update_time);
  return out;
}

}  // namespace enfilade::server
