// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/area/convert.h"
#include "server/rpc/area/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
namespace {

// `area` with the fields that are updated.
void MergeArea(const google::protobuf::FieldMask& mask, const v1::MapArea& wanted, v1::MapArea& area) {
  if (IsUpdated(mask, "display_name", !wanted.display_name().empty())) area.set_display_name(wanted.display_name());
  if (IsUpdated(mask, "kind", wanted.kind() != 0)) area.set_kind(wanted.kind());
  if (IsUpdated(mask, "outline", wanted.has_outline())) *area.mutable_outline() = wanted.outline();
  if (IsUpdated(mask, "robot_types", wanted.robot_types_size() > 0)) {
    *area.mutable_robot_types() = wanted.robot_types();
  }
  if (IsUpdated(mask, "speed_limit_mps", wanted.speed_limit_mps() != 0.0)) {
    area.set_speed_limit_mps(wanted.speed_limit_mps());
  } else if (area.kind() != v1::MapArea::KIND_SPEED_LIMIT) {
    area.clear_speed_limit_mps();  // an area that no longer limits the speed
  }
  if (IsUpdated(mask, "valid_from", wanted.has_valid_from())) {
    area.clear_valid_from();
    if (wanted.has_valid_from()) *area.mutable_valid_from() = wanted.valid_from();
  }
  if (IsUpdated(mask, "valid_until", wanted.has_valid_until())) {
    area.clear_valid_until();
    if (wanted.has_valid_until()) *area.mutable_valid_until() = wanted.valid_until();
  }
}

}  // namespace

absl::StatusOr<v1::UpdateMapAreaResponse> UpdateMapArea(const Services& services, const Call& call,
                                                        const v1::UpdateMapAreaRequest& request) {
  v1::UpdateMapAreaResponse response;
  ENFILADE_RETURN_IF_ERROR(CheckMask(request.update_mask(), {"display_name", "kind", "outline", "robot_types",
                                                             "speed_limit_mps", "valid_from", "valid_until"}));
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapAreaName name,
                            convert::ParseMapAreaName("area.name", request.area().name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.area().etag()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapArea stored,
                            services.map_areas.Get(call.context(), name.site, name.map, name.area));
  v1::MapArea merged = ToProto(stored);
  MergeArea(request.update_mask(), request.area(), merged);
  storage::MapArea changed;
  changed.site = name.site;
  changed.map = name.map;
  changed.id = name.area;
  ENFILADE_ASSIGN_OR_RETURN(changed.area, FromProto(merged));
  changed.etag = etag != 0 ? etag : stored.etag;
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapArea updated,
                            services.map_areas.Update(call.context(), changed, request.force()));
  constexpr auto kIgnoreHits = areas::AreaKind::kIgnoreHits;
  if (stored.area.kind == kIgnoreHits || updated.area.kind == kIgnoreHits) {
    ENFILADE_RETURN_IF_ERROR(services.map_edits.Recompose(call.context(), {updated.site, updated.map}));
  }
  *response.mutable_area() = ToProto(updated);
  return response;
}

}  // namespace enfilade::server
