// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/base/time.h"

namespace enfilade::areas {

// The numbers are those of the API and of the database: never reuse one.
enum class AreaKind : std::int16_t {
  kKeepOut = 1,     // robots stay out
  kSpeedLimit = 2,  // robots drive no faster
  kPreferred = 3,   // ways through it are better
  kIgnoreHits = 4,  // hits inside are not mapped
  kRoom = 5,
  kDock = 6,
};

// "keep-out", "speed-limit", "preferred", "ignore-hits", "room", "dock".
std::string_view NameOfKind(AreaKind kind);
// Unset: no kind has that name.
std::optional<AreaKind> KindOfName(std::string_view name);
// All, as NameOfKind says them.
const std::vector<std::string>& KindNames();

constexpr std::size_t kMinAreaCorners = 3;
constexpr std::size_t kMaxAreaCorners = 1'000;
constexpr std::size_t kMaxRobotTypes = 20;
constexpr double kMaxAreaCoordinate = 1e6;  // m, from the map's origin

// A part of a map with a meaning. It changes no cell of the map.
struct MapArea {
  AreaKind kind = AreaKind::kKeepOut;
  std::string display_name;              // 1 to 200 characters
  std::vector<Eigen::Vector2d> outline;  // m, in the map's frame; the first corner is not repeated at the end
  std::vector<std::string> robot_types;  // for which it holds; empty: for all
  double speed_limit_mps = 0.0;          // kSpeedLimit only, more than 0; otherwise 0
  // From when, and until before when it holds. Unset: without an end.
  std::optional<TimeNs> valid_from;
  std::optional<TimeNs> valid_until;
};

// INVALID_ARGUMENT. The message begins with the field: an outline that is not simple (ValidateSimplePolygon) or has too
// few or too many corners; a robot type that is not 1 to 63 of a-z, 0-9 and "-", or that comes twice, or too many; a
// speed where none belongs, or none where one does; a validity that ends before it begins. The name is not checked.
absl::Status Validate(const MapArea& area);

// Whether it holds for robots of a type (empty: of any) at a time (unset: at any).
bool HoldsFor(const MapArea& area, std::string_view robot_type, std::optional<TimeNs> time);

}  // namespace enfilade::areas
