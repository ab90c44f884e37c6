// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/area/convert.h"

#include <optional>
#include <string>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "proto/convert/record.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
namespace {

constexpr TimeNs kNsPerMicrosecond = 1'000;

// In whole microseconds, as areas are stored.
absl::StatusOr<std::optional<TimeNs>> ValidityOf(const char* field, bool is_set,
                                                 const google::protobuf::Timestamp& given) {
  if (!is_set) return std::optional<TimeNs>();
  const absl::StatusOr<TimeNs> time = convert::FromTimestamp(given);
  if (!time.ok()) return WithContext(time.status(), field);
  return std::optional<TimeNs>(*time - *time % kNsPerMicrosecond);
}

}  // namespace

v1::MapArea ToProto(const storage::MapArea& stored) {
  const areas::MapArea& area = stored.area;
  v1::MapArea out;
  out.set_name(NameOf(stored.site, stored.map, stored.id));
  out.set_display_name(area.display_name);
  static_assert(static_cast<int>(areas::AreaKind::kDock) == v1::MapArea::KIND_DOCK);
  out.set_kind(static_cast<v1::MapArea::Kind>(area.kind));
  for (const Eigen::Vector2d& corner : area.outline) {
    v1::Point& added = *out.mutable_outline()->add_corners();
    added.set_x(corner.x());
    added.set_y(corner.y());
  }
  for (const std::string& type : area.robot_types) out.add_robot_types(type);
  out.set_speed_limit_mps(area.speed_limit_mps);
  if (area.valid_from) *out.mutable_valid_from() = convert::ToTimestamp(*area.valid_from);
  if (area.valid_until) *out.mutable_valid_until() = convert::ToTimestamp(*area.valid_until);
  out.set_etag(std::to_string(stored.etag));
  *out.mutable_create_time() = convert::ToTimestamp(stored.create_time);
  *out.mutable_update_time() = convert::ToTimestamp(stored.update_time);
  return out;
}

absl::StatusOr<areas::MapArea> FromProto(const v1::MapArea& in) {
  if (in.kind() == v1::MapArea::KIND_UNSPECIFIED || !v1::MapArea::Kind_IsValid(in.kind())) {
    return InvalidArgument("area.kind is {}: expected one of KIND_KEEP_OUT to KIND_DOCK", static_cast<int>(in.kind()));
  }
  ENFILADE_RETURN_IF_ERROR(CheckDisplayName("area.display_name", in.display_name()));
  areas::MapArea area;
  area.kind = static_cast<areas::AreaKind>(in.kind());
  area.display_name = in.display_name();
  for (const v1::Point& corner : in.outline().corners()) area.outline.emplace_back(corner.x(), corner.y());
  area.robot_types.assign(in.robot_types().begin(), in.robot_types().end());
  area.speed_limit_mps = in.speed_limit_mps();
  ENFILADE_ASSIGN_OR_RETURN(area.valid_from, ValidityOf("area.valid_from", in.has_valid_from(), in.valid_from()));
  ENFILADE_ASSIGN_OR_RETURN(area.valid_until, ValidityOf("area.valid_until", in.has_valid_until(), in.valid_until()));
  const absl::Status valid = areas::Validate(area);
  if (!valid.ok()) return InvalidArgument("area.{}", std::string(valid.message()));
  return area;
}

}  // namespace enfilade::server
