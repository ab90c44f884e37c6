// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/maps.h"

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "proto/convert/names.h"

namespace enfilade::client {

absl::StatusOr<v1::Map> FindMap(const Connection& connection, const SiteId& site, const std::string& map) {
  v1::ListMapsRequest by_display_name;
  by_display_name.set_parent(NameOf(site));
  by_display_name.set_display_name(map);
  ENFILADE_ASSIGN_OR_RETURN(const v1::ListMapsResponse named,
                            connection.Call(&v1::MapService::Stub::ListMaps, by_display_name));
  if (!map.empty() && named.maps_size() == 1) return named.maps(0);

  v1::GetMapRequest by_name;
  by_name.set_name(IsValidResourceId(map) ? convert::NameOf(convert::MapName{site, MapId(map)}) : map);
  if (by_name.name().rfind("sites/", 0) == 0) {
    const auto found = connection.Call(&v1::MapService::Stub::GetMap, by_name);
    if (found.ok()) return found->map();
    if (!absl::IsNotFound(found.status()) && !absl::IsInvalidArgument(found.status())) return found.status();
  }
  return NotFound("site \"{}\" has no map \"{}\": see `enfilade map list`", site.value(), map);
}

absl::StatusOr<v1::Map> FindOrCreateMap(const Connection& connection, const SiteId& site, const std::string& map,
                                        v1::CreateMapRequest request) {
  absl::StatusOr<v1::Map> found = FindMap(connection, site, map);
  if (!absl::IsNotFound(found.status())) return found;
  request.set_parent(NameOf(site));
  const auto created = connection.Call(&v1::MapService::Stub::CreateMap, request);
  if (created.ok()) return created->map();
  if (absl::IsAlreadyExists(created.status())) return FindMap(connection, site, map);
  return created.status();
}

}  // namespace enfilade::client
