// SPDX-License-Identifier: Apache-2.0
#include "core/areas/map_area.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/areas/simple_polygon.h"
#include "core/base/error.h"
#include "core/base/excerpt.h"
#include "core/base/ids.h"
#include "core/base/status_macros.h"

namespace enfilade::areas {
namespace {

struct NamedKind {
  AreaKind kind;
  std::string_view name;
};
constexpr std::array kKinds = {
    NamedKind{AreaKind::kKeepOut, "keep-out"},    NamedKind{AreaKind::kSpeedLimit, "speed-limit"},
    NamedKind{AreaKind::kPreferred, "preferred"}, NamedKind{AreaKind::kIgnoreHits, "ignore-hits"},
    NamedKind{AreaKind::kRoom, "room"},           NamedKind{AreaKind::kDock, "dock"},
};

absl::Status ValidateRobotTypes(const std::vector<std::string>& types) {
  if (types.size() > kMaxRobotTypes) {
    return InvalidArgument("robot_types has {} types: at most {} are allowed", types.size(), kMaxRobotTypes);
  }
  for (std::size_t i = 0; i < types.size(); ++i) {
    if (!IsValidResourceId(types[i])) {
      return InvalidArgument(
          "robot_types[{}] is \"{}\": expected 1 to 63 of a-z, 0-9 and \"-\", not \"-\" first or last", i,
          Excerpt(types[i], 100));
    }
    const auto end = types.begin() + static_cast<std::ptrdiff_t>(i);
    if (std::find(types.begin(), end, types[i]) != end) {
      return InvalidArgument("robot_types[{}] is \"{}\", which was named before: name it once", i, types[i]);
    }
  }
  return absl::OkStatus();
}

absl::Status ValidateSpeed(const MapArea& area) {
  const double speed = area.speed_limit_mps;
  if (area.kind != AreaKind::kSpeedLimit) {
    if (speed == 0.0) return absl::OkStatus();
    return InvalidArgument("speed_limit_mps is {}: only an area of the kind speed-limit has one; leave it out", speed);
  }
  if (std::isfinite(speed) && speed > 0.0) return absl::OkStatus();
  return InvalidArgument("speed_limit_mps is {}: expected metres per second, more than 0", speed);
}

absl::Status ValidateOutline(const std::vector<Eigen::Vector2d>& outline) {
  if (outline.size() < kMinAreaCorners || outline.size() > kMaxAreaCorners) {
    return InvalidArgument("outline has {} corners: expected {} to {}", outline.size(), kMinAreaCorners,
                           kMaxAreaCorners);
  }
  return WithContext(ValidateSimplePolygon(outline, kMaxAreaCoordinate), "outline");
}

}  // namespace

std::string_view NameOfKind(AreaKind kind) {
  for (const NamedKind& named : kKinds) {
    if (named.kind == kind) return named.name;
  }
  return "unknown";
}

std::optional<AreaKind> KindOfName(std::string_view name) {
  for (const NamedKind& named : kKinds) {
    if (named.name == name) return named.kind;
  }
  return std::nullopt;
}

const std::vector<std::string>& KindNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const NamedKind& named : kKinds) all.emplace_back(named.name);
    return all;
  }();
  return names;
}

absl::Status Validate(const MapArea& area) {
  ENFILADE_RETURN_IF_ERROR(ValidateOutline(area.outline));
  ENFILADE_RETURN_IF_ERROR(ValidateRobotTypes(area.robot_types));
  ENFILADE_RETURN_IF_ERROR(ValidateSpeed(area));
  if (area.valid_from && area.valid_until && *area.valid_from >= *area.valid_until) {
    return InvalidArgument("valid_until is not after valid_from: the area would never hold");
  }
  return absl::OkStatus();
}

bool HoldsFor(const MapArea& area, std::string_view robot_type, std::optional<TimeNs> time) {
  if (time && area.valid_from && *time < *area.valid_from) return false;
  if (time && area.valid_until && *time >= *area.valid_until) return false;
  if (robot_type.empty() || area.robot_types.empty()) return true;
  return std::find(area.robot_types.begin(), area.robot_types.end(), robot_type) != area.robot_types.end();
}

}  // namespace enfilade::areas
