// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/wall_doors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/prior/plan/segment_grid.h"

namespace enfilade::perception {
namespace {

using Eigen::Vector2d;

// A wall's end that no other wall touches.
struct FreeEnd {
  int corner = 0;
  int wall = 0;
  Vector2d point;
  Vector2d outward;
  double thickness = 0;
};

struct Opening {
  int end = 0;
  int other_end = -1;  // -1: a wall's side
  Vector2d from, to;
  double width() const { return (to - from).norm(); }
};

std::vector<FreeEnd> FreeEndsOf(const prior::PlanGraph& plan) {
  std::vector<int> degree(plan.corners.size(), 0);
  for (const prior::PlanWall& wall : plan.walls) ++degree[wall.from], ++degree[wall.to];
  std::vector<FreeEnd> ends;
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    const prior::PlanWall& wall = plan.walls[i];
    const Vector2d a = plan.corners[wall.from].point, b = plan.corners[wall.to].point;
    const Vector2d along = (b - a).normalized();
    if (degree[wall.from] == 1) ends.push_back({wall.from, static_cast<int>(i), a, -along, wall.thickness});
    if (degree[wall.to] == 1) ends.push_back({wall.to, static_cast<int>(i), b, along, wall.thickness});
  }
  return ends;
}

constexpr double kBeyondWall = 0.02;  // of a wall's length: a ray hits it that far beyond its ends

// The nearest wall that the ray from an end hits within `reach`.
std::optional<double> FirstHit(const prior::PlanGraph& plan, const prior::SegmentGrid& walls, const FreeEnd& end,
                               double reach) {
  std::optional<double> nearest;
  walls.ForEachNear(end.point, end.point + reach * end.outward, [&](int i) {
    if (i == end.wall) return;
    const Vector2d a = plan.corners[plan.walls[i].from].point;
    const Vector2d along = plan.corners[plan.walls[i].to].point - a;
    const double turn = end.outward.x() * along.y() - end.outward.y() * along.x();
    if (std::abs(turn) < 0.3 * along.norm()) return;
    const Vector2d offset = a - end.point;
    const double distance = (offset.x() * along.y() - offset.y() * along.x()) / turn;
    const double share = (offset.x() * end.outward.y() - offset.y() * end.outward.x()) / turn;
    if (distance <= 0 || distance > reach || share < -kBeyondWall || share > 1 + kBeyondWall) return;
    if (!nearest || distance < *nearest) nearest = distance;
  });
  return nearest;
}

// How far an end may lie aside of the line of another that faces it.
double LooseBetween(double thickness, double other) { return std::max(2.0, 0.6 * std::max(thickness, other)); }

// The nearest end that faces this one in line.
std::optional<int> FacingEnd(const std::vector<FreeEnd>& ends, const prior::SegmentGrid& grid, int index,
                             double reach) {
  constexpr double kFacing = -0.98;  // the cosine of 168 degrees
  const FreeEnd& end = ends[index];
  std::optional<int> best;
  double nearest = reach;
  grid.ForEachNear(end.point, end.point + reach * end.outward, [&](int j) {
    const FreeEnd& other = ends[j];
    if (j == index || end.outward.dot(other.outward) > kFacing) return;
    const Vector2d gap = other.point - end.point;
    const double along = gap.dot(end.outward);
    const double aside = std::abs(gap.x() * end.outward.y() - gap.y() * end.outward.x());
    if (along <= 0 || along > nearest || aside > LooseBetween(end.thickness, other.thickness)) return;
    if (best && along == nearest && j < *best) return;
    nearest = along;
    best = j;
  });
  return best;
}

// Ends, and walls, by where they are: those near a ray are found without a look at all of them.
prior::SegmentGrid GridOfEnds(const std::vector<FreeEnd>& ends, double cell) {
  double thickest = 0;
  for (const FreeEnd& end : ends) thickest = std::max(thickest, end.thickness);
  prior::SegmentGrid grid(std::max(LooseBetween(thickest, 0), cell));
  for (std::size_t i = 0; i < ends.size(); ++i) grid.Add(static_cast<int>(i), ends[i].point, ends[i].point);
  return grid;
}

prior::SegmentGrid GridOfSides(const prior::PlanGraph& plan, double cell) {
  prior::SegmentGrid grid(cell);
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    const Vector2d a = plan.corners[plan.walls[i].from].point, b = plan.corners[plan.walls[i].to].point;
    grid.Add(static_cast<int>(i), a - kBeyondWall * (b - a), b + kBeyondWall * (b - a));
  }
  return grid;
}

std::vector<Opening> OpeningsOf(const prior::PlanGraph& plan, const std::vector<FreeEnd>& ends, double reach) {
  std::vector<Opening> openings;
  if (ends.empty()) return openings;
  const double cell = std::max(prior::WallLength(plan) / static_cast<double>(plan.walls.size()), reach / 100);
  const prior::SegmentGrid sides = GridOfSides(plan, cell);
  const prior::SegmentGrid grid = GridOfEnds(ends, cell);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const int index = static_cast<int>(i);
    const std::optional<double> hit = FirstHit(plan, sides, ends[i], reach);
    const std::optional<int> facing = FacingEnd(ends, grid, index, hit ? std::min(reach, *hit) : reach);
    if (facing && *facing < index) continue;  // found from the other end
    if (facing) {
      openings.push_back({index, *facing, ends[i].point, ends[*facing].point});
    } else if (hit) {
      openings.push_back({index, -1, ends[i].point, ends[i].point + *hit * ends[i].outward});
    }
  }
  return openings;
}

// The width that most openings have: that with the most others within a quarter of it.
double UsualWidth(const std::vector<Opening>& openings) {
  std::vector<double> widths;
  for (const Opening& opening : openings) widths.push_back(opening.width());
  std::sort(widths.begin(), widths.end());
  double usual = 0;
  std::ptrdiff_t most = 0;
  for (const Opening& opening : openings) {
    const auto first = std::upper_bound(widths.begin(), widths.end(), opening.width() / 1.25);
    const auto last = std::lower_bound(widths.begin(), widths.end(), opening.width() * 1.25);
    if (last - first > most) most = last - first, usual = opening.width();
  }
  return usual;
}

}  // namespace

std::vector<prior::PlanDoor> FindDoors(const prior::PlanGraph& plan, double diagonal) {
  constexpr double kReachShare = 0.08;  // of the diagonal
  const double reach = plan.metres_per_unit ? 2.2 / *plan.metres_per_unit : kReachShare * diagonal;
  const std::vector<FreeEnd> ends = FreeEndsOf(plan);
  const std::vector<Opening> openings = OpeningsOf(plan, ends, reach);
  const double usual = UsualWidth(openings);
  const double narrowest = plan.metres_per_unit ? 0.6 / *plan.metres_per_unit : 0.5 * usual;
  const double widest = plan.metres_per_unit ? reach : 2.0 * usual;
  std::vector<prior::PlanDoor> doors;
  for (const Opening& opening : openings) {
    if (opening.width() < narrowest || opening.width() > widest) continue;
    doors.push_back({opening.from, opening.to, opening.other_end >= 0 ? 0.7 : 0.5});
  }
  return doors;
}

}  // namespace enfilade::perception
