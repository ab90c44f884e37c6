// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/world/door_gaps.h"

#include <cmath>
#include <utility>

namespace enfilade::simulator {
namespace {

constexpr double kAlong = 0.3;  // m: a door cuts the walls that are no farther from its line

}  // namespace

std::vector<DoorGap> DoorGapsOf(const Campus& campus, const std::string& level, const Eigen::Vector2d& from,
                                const Eigen::Vector2d& to) {
  std::vector<DoorGap> gaps;
  const double length = (to - from).norm();
  if (!(length > 0.0)) return gaps;
  const Eigen::Vector2d on = (to - from) / length;
  const auto along = [&](const Eigen::Vector2d& point) { return on.dot(point - from); };
  const auto beside = [&](const Eigen::Vector2d& point) {
    return std::abs(on.x() * (point - from).y() - on.y() * (point - from).x());
  };
  for (const Door& door : campus.doors) {
    if (door.level != level || beside(door.a) > kAlong || beside(door.b) > kAlong) continue;
    double begin = along(door.a);
    double end = along(door.b);
    if (begin > end) std::swap(begin, end);
    if (end - begin < 0.9 * door.width() || end < 1e-6 || begin > length - 1e-6) continue;
    gaps.push_back({begin, end, &door});
  }
  return gaps;
}

}  // namespace enfilade::simulator
