// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::UpdateMapResponse> UpdateMap(const Services& services, const Call& call,
                                                const v1::UpdateMapRequest& request) {
  v1::UpdateMapResponse response;
  const auto& mask = request.update_mask();
  const v1::Map& wanted = request.map();
  ENFILADE_RETURN_IF_ERROR(
      CheckMask(mask, {"display_name", "level", "environment", "slam_profile", "outline", "pinned"}));
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName name, convert::ParseMapName("map.name", wanted.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(wanted.etag()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map stored, services.maps.Get(call.context(), name.site, name.map));

  v1::Map changed = ToProto(stored);
  if (IsUpdated(mask, "display_name", !wanted.display_name().empty())) changed.set_display_name(wanted.display_name());
  if (IsUpdated(mask, "level", wanted.level() != 0)) changed.set_level(wanted.level());
  if (IsUpdated(mask, "environment", wanted.environment() != 0)) changed.set_environment(wanted.environment());
  if (IsUpdated(mask, "slam_profile", !wanted.slam_profile().empty())) changed.set_slam_profile(wanted.slam_profile());
  if (IsUpdated(mask, "outline", wanted.has_outline())) *changed.mutable_outline() = wanted.outline();
  if (IsUpdated(mask, "pinned", wanted.pinned())) changed.set_pinned(wanted.pinned());
  ENFILADE_ASSIGN_OR_RETURN(storage::Map map, FromProto(changed));
  map.site = name.site;
  map.id = name.map;
  map.etag = etag != 0 ? etag : stored.etag;
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map updated, services.graph_editor.UpdateMap(call.context(), map));
  *response.mutable_map() = ToProto(updated);
  return response;
}

}  // namespace enfilade::server
