// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/wall_gaps.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/geometry/segments.h"

namespace enfilade::simulator {
namespace {

constexpr double kNarrowest = 0.6;  // m
constexpr double kWidest = 1.8;     // m
constexpr double kTouch = 0.15;     // m: walls so near to each other are joined
constexpr double kDoorTouch = 0.3;  // m
constexpr double kAside = 0.2;      // m: the other wall's end may be so far off the line

double DistanceToBarrier(const Eigen::Vector2d& point, const Barrier& barrier) {
  return DistanceToSegment(point, barrier.first, barrier.second);
}

// The first place of `wall` ahead of `end`: where it begins near the line, or crosses it. m along the line.
std::optional<double> MeetsAt(const Eigen::Vector2d& end, const Eigen::Vector2d& ahead, const Barrier& wall) {
  const Eigen::Vector2d aside(-ahead.y(), ahead.x());
  std::optional<double> nearest;
  const auto offer = [&](double along) {
    if (along > 0.0 && (!nearest || along < *nearest)) nearest = along;
  };
  for (const Eigen::Vector2d& point : {wall.first, wall.second}) {
    if (std::abs(aside.dot(point - end)) <= kAside) offer(ahead.dot(point - end));
  }
  const double a = aside.dot(wall.first - end);
  const double b = aside.dot(wall.second - end);
  if (a * b < 0.0) offer(ahead.dot(wall.first - end + a / (a - b) * (wall.second - wall.first)));
  return nearest;
}

}  // namespace

std::vector<Barrier> GapsBetween(const std::vector<Barrier>& walls, const std::vector<Barrier>& doors) {
  std::vector<Barrier> gaps;
  const auto known = [&gaps](const Barrier& gap) {
    return std::any_of(gaps.begin(), gaps.end(), [&](const Barrier& other) {
      return std::min((gap.first - other.first).norm() + (gap.second - other.second).norm(),
                      (gap.first - other.second).norm() + (gap.second - other.first).norm()) < 2.0 * kDoorTouch;
    });
  };
  for (std::size_t i = 0; i < walls.size(); ++i) {
    for (const auto& [begin, end] : {walls[i], Barrier(walls[i].second, walls[i].first)}) {
      if ((end - begin).norm() < kTouch) continue;
      const Eigen::Vector2d ahead = (end - begin).normalized();
      bool free = std::none_of(doors.begin(), doors.end(), [&, tip = end](const Barrier& door) {
        return DistanceToBarrier(tip, door) < kDoorTouch;
      });
      std::optional<double> nearest;
      for (std::size_t k = 0; k < walls.size() && free; ++k) {
        if (k == i) continue;
        free = DistanceToBarrier(end, walls[k]) >= kTouch;
        const std::optional<double> along = MeetsAt(end, ahead, walls[k]);
        if (along && (!nearest || *along < *nearest)) nearest = along;
      }
      if (!free || !nearest || *nearest < kNarrowest || *nearest > kWidest) continue;
      const Barrier gap(end, end + *nearest * ahead);
      if (!known(gap)) gaps.push_back(gap);
    }
  }
  return gaps;
}

}  // namespace enfilade::simulator
