// SPDX-License-Identifier: Apache-2.0
#include "core/prior/plan/room_names.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;

// Where the outline crosses the height y, from left to right; an even number of places.
std::vector<double> CrossingsAt(const std::vector<Vector2d>& outline, double y) {
  std::vector<double> crossings;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d& a = outline[i];
    const Vector2d& b = outline[(i + 1) % outline.size()];
    if ((a.y() <= y) != (b.y() <= y)) crossings.push_back(a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
  }
  std::sort(crossings.begin(), crossings.end());
  return crossings;
}

bool IsInside(const std::vector<Vector2d>& outline, const Vector2d& p) {
  const std::vector<double> crossings = CrossingsAt(outline, p.y());
  return std::count_if(crossings.begin(), crossings.end(), [&](double x) { return x < p.x(); }) % 2 == 1;
}

}  // namespace

double AreaOf(const std::vector<Vector2d>& outline) {
  double twice = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d& a = outline[i];
    const Vector2d& b = outline[(i + 1) % outline.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

Vector2d InsideOf(const std::vector<Vector2d>& outline) {
  const auto [low, high] =
      std::minmax_element(outline.begin(), outline.end(), [](const auto& a, const auto& b) { return a.y() < b.y(); });
  const double y = (low->y() + high->y()) / 2;
  const std::vector<double> crossings = CrossingsAt(outline, y);
  Vector2d inside(low->x(), y);
  double widest = 0;
  for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
    const double width = crossings[i + 1] - crossings[i];
    if (width <= widest) continue;
    widest = width;
    inside.x() = (crossings[i] + crossings[i + 1]) / 2;
  }
  return inside;
}

std::vector<PlanRoom> WithNamesOf(const std::vector<PlanRoom>& named, std::vector<PlanRoom> rooms) {
  std::vector<double> largest(rooms.size(), 0);
  for (const PlanRoom& room : named) {
    if (room.name.empty()) continue;
    const Vector2d inside = InsideOf(room.outline);
    const double size = std::abs(AreaOf(room.outline));
    for (std::size_t i = 0; i < rooms.size(); ++i) {
      if (size <= largest[i] || !IsInside(rooms[i].outline, inside)) continue;
      largest[i] = size;
      rooms[i].name = room.name;
    }
  }
  return rooms;
}

}  // namespace enfilade::prior
