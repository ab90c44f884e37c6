// SPDX-License-Identifier: Apache-2.0
#include "client/cli/commands/area/area_fields.h"

#include <sstream>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "client/cli/numbers.h"
#include "core/areas/map_area.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::cli {
namespace {

constexpr const char* kNoEnd = "none";

absl::Status FillOutline(const std::string& polygon, v1::Polygon& outline) {
  std::istringstream corners(polygon);
  std::string corner;
  while (corners >> corner) {
    const auto numbers = ParseNumbers(corner, 2);
    if (!numbers) {
      return InvalidArgument("--polygon has \"{}\": expected \"X,Y X,Y X,Y ...\" in metres of the map's frame", corner);
    }
    v1::Point& added = *outline.add_corners();
    added.set_x((*numbers)[0]);
    added.set_y((*numbers)[1]);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<google::protobuf::Timestamp> ParseTimeOption(const char* option, const std::string& text) {
  absl::Time time;
  std::string why;
  if (!absl::ParseTime(absl::RFC3339_full, absl::string_view(text), &time, &why) || time == absl::InfiniteFuture() ||
      time == absl::InfinitePast()) {
    return InvalidArgument("{} is \"{}\": expected a time as in 2026-01-31T08:00:00Z", option, text);
  }
  const timespec parts = absl::ToTimespec(time);
  google::protobuf::Timestamp timestamp;
  timestamp.set_seconds(parts.tv_sec);
  timestamp.set_nanos(static_cast<std::int32_t>(parts.tv_nsec));
  return timestamp;
}

void AddAreaFields(CLI::App& command, AreaFields& fields) {
  command.add_option("--kind", fields.kind, "keep-out, speed-limit, preferred, ignore-hits, room or dock")
      ->check(CLI::IsMember(areas::KindNames()));
  command.add_option("--polygon", fields.polygon, "Its corners in the map's frame: \"X,Y X,Y X,Y ...\" in metres");
  command.add_option("--robot-type", fields.robot_types,
                     "It holds for robots of this type only; may be repeated (default: for all)");
  command.add_option("--speed", fields.speed, "Of a speed limit: metres per second");
  command.add_option("--from", fields.from, "When it begins to hold: 2026-01-31T08:00:00Z, or none");
  command.add_option("--until", fields.until, "When it no longer holds: 2026-01-31T08:00:00Z, or none");
}

absl::Status FillArea(const AreaFields& fields, v1::MapArea& area, google::protobuf::FieldMask& mask) {
  if (fields.name) {
    area.set_display_name(*fields.name);
    mask.add_paths("display_name");
  }
  if (fields.kind) {
    area.set_kind(static_cast<v1::MapArea::Kind>(*areas::KindOfName(*fields.kind)));
    mask.add_paths("kind");
  }
  if (fields.polygon) {
    ENFILADE_RETURN_IF_ERROR(FillOutline(*fields.polygon, *area.mutable_outline()));
    mask.add_paths("outline");
  }
  if (!fields.robot_types.empty() || fields.all_robots) {
    for (const std::string& type : fields.robot_types) area.add_robot_types(type);
    mask.add_paths("robot_types");
  }
  if (fields.speed) {
    area.set_speed_limit_mps(*fields.speed);
    mask.add_paths("speed_limit_mps");
  }
  if (fields.from) {
    mask.add_paths("valid_from");
    if (*fields.from != kNoEnd) {
      ENFILADE_ASSIGN_OR_RETURN(*area.mutable_valid_from(), ParseTimeOption("--from", *fields.from));
    }
  }
  if (fields.until) {
    mask.add_paths("valid_until");
    if (*fields.until != kNoEnd) {
      ENFILADE_ASSIGN_OR_RETURN(*area.mutable_valid_until(), ParseTimeOption("--until", *fields.until));
    }
  }
  return absl::OkStatus();
}

}  // namespace enfilade::cli
