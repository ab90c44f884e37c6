// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/map/named_revision.h"

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

bool IsAliasName(std::string_view name) { return name.find("/aliases/") != std::string_view::npos; }

absl::StatusOr<convert::RevisionName> FollowAlias(const Services& services, const storage::CallContext& context,
                                                  std::string_view field, const std::string& name) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapAliasName alias, convert::ParseMapAliasName(field, name));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapAlias stored,
                            services.map_aliases.Get(context, alias.site, alias.map, alias.alias));
  return convert::RevisionName{stored.site, stored.map, stored.revision};
}

}  // namespace

absl::StatusOr<convert::RevisionName> ResolveRevision(const Services& services, const storage::CallContext& context,
                                                      std::string_view field, const std::string& name) {
  if (IsAliasName(name)) return FollowAlias(services, context, field, name);
  return convert::ParseRevisionName(field, name);
}

absl::StatusOr<convert::RevisionName> ResolveMapOrRevision(const Services& services,
                                                           const storage::CallContext& context, std::string_view field,
                                                           const std::string& name) {
  if (IsAliasName(name)) return FollowAlias(services, context, field, name);
  return convert::ParseMapOrRevisionName(field, name);
}

}  // namespace enfilade::server
