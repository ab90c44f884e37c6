// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/path_narrows.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace enfilade::rooms {
namespace {

// A line across the path at one of its points.
struct Section {
  DoorCandidate line;
  double length = 0.0;  // cells; greater than allowed if there is no wall within reach
};

// The path in cells, with a point in each that it crosses. A jump begins a new way.
std::vector<std::vector<Eigen::Vector2d>> Resample(const GroundMap& ground, const grid::GridGeometry& geometry,
                                                   std::span<const Eigen::Vector2d> path) {
  const double longest_step = kLongestStep / ground.resolution;
  std::vector<std::vector<Eigen::Vector2d>> ways;
  for (const Eigen::Vector2d& p_map : path) {
    const Eigen::Vector2d p = ToCells(geometry, p_map);
    if (!(p.x() > 0.0 && p.y() > 0.0 && p.x() < ground.width && p.y() < ground.height)) continue;
    if (ways.empty() || (p - ways.back().back()).norm() > longest_step) {
      ways.push_back({p});
      continue;
    }
    const Eigen::Vector2d from = ways.back().back();
    const double distance = (p - from).norm();
    for (double at = 1.0; at <= distance; at += 1.0) ways.back().push_back(from + at / distance * (p - from));
  }
  return ways;
}

// From `from` to the first wall or unknown cell; unset if none is within `reach` cells.
std::optional<Eigen::Vector2d> FirstObstacle(const GroundMap& ground, const Eigen::Vector2d& from,
                                             const Eigen::Vector2d& direction, double reach) {
  for (double at = 1.0; at <= reach; at += 1.0) {
    const Eigen::Vector2d p = from + at * direction;
    if (!ground.IsOpen(p)) return Eigen::Vector2d(std::round(p.x()), std::round(p.y()));
  }
  return std::nullopt;
}

Section SectionAt(const GroundMap& ground, const Eigen::Vector2d& at, const Eigen::Vector2d& direction,
                  double max_length) {
  const auto a = FirstObstacle(ground, at, -direction, max_length);
  const auto b = a ? FirstObstacle(ground, at, direction, max_length - (*a - at).norm()) : std::nullopt;
  if (!b) return {{}, 2.0 * max_length};
  return {{*a, *b}, (*b - *a).norm()};
}

// The direction of the walls around each point, radians: of the four, the one nearest to that of the point before.
std::vector<double> WallDirectionsAlong(const GroundMap& ground, const std::vector<Eigen::Vector2d>& way) {
  constexpr std::size_t kEvery = 5;  // points
  std::vector<double> directions;
  double direction = 0.0;
  for (std::size_t i = 0; i < way.size(); ++i) {
    if (i % kEvery == 0) {
      const double found = WallDirectionNear(ground, way[i]).value_or(direction);
      direction = found + std::round((direction - found) / (M_PI / 2.0)) * M_PI / 2.0;
    }
    directions.push_back(direction);
  }
  return directions;
}

// Is the section at `i` the first of the shortest within `reach`, and are there longer ones by `rise` on both sides?
bool IsNarrow(const std::vector<Section>& sections, std::size_t i, std::size_t reach, double rise) {
  const double here = sections[i].length;
  const std::size_t first = i > reach ? i - reach : 0;
  const std::size_t last = std::min(i + reach, sections.size() - 1);
  double before = 0.0;
  double behind = 0.0;
  for (std::size_t k = first; k < i; ++k) {
    if (sections[k].length <= here) return false;
    before = std::max(before, sections[k].length);
  }
  for (std::size_t k = i + 1; k <= last; ++k) {
    if (sections[k].length < here) return false;
    behind = std::max(behind, sections[k].length);
  }
  return before >= here + rise && behind >= here + rise;
}

}  // namespace

std::vector<DoorCandidate> FindNarrowsOnPath(const GroundMap& ground, const grid::GridGeometry& geometry,
                                             std::span<const Eigen::Vector2d> path, double max_length) {
  constexpr double kReach = 0.6;  // m
  constexpr double kRise = 0.2;   // m
  const auto reach = static_cast<std::size_t>(kReach / ground.resolution);
  const double longest = max_length / ground.resolution;
  std::vector<DoorCandidate> narrows;
  for (const std::vector<Eigen::Vector2d>& way : Resample(ground, geometry, path)) {
    const std::vector<double> walls = WallDirectionsAlong(ground, way);
    for (const double turn : {0.0, M_PI / 2.0}) {
      std::vector<Section> sections;
      for (std::size_t i = 0; i < way.size(); ++i) {
        const double angle = walls[i] + turn;
        sections.push_back(SectionAt(ground, way[i], {std::cos(angle), std::sin(angle)}, longest));
      }
      for (std::size_t i = 0; i < sections.size(); ++i) {
        if (sections[i].length <= longest && IsNarrow(sections, i, reach, kRise / ground.resolution)) {
          narrows.push_back(sections[i].line);
        }
      }
    }
  }
  return narrows;
}

}  // namespace enfilade::rooms
