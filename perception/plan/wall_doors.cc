// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/wall_doors.h"

#include <algorithm>
#include <cmath>
#include <optional>

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

// The nearest wall that the ray from an end hits within `reach`.
std::optional<double> FirstHit(const prior::PlanGraph& plan, const FreeEnd& end, double reach) {
  std::optional<double> nearest;
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    if (static_cast<int>(i) == end.wall) continue;
    const Vector2d a = plan.corners[plan.walls[i].from].point;
    const Vector2d along = plan.corners[plan.walls[i].to].point - a;
    const double turn = end.outward.x() * along.y() - end.outward.y() * along.x();
    if (std::abs(turn) < 0.3 * along.norm()) continue;
    const Vector2d offset = a - end.point;
    const double distance = (offset.x() * along.y() - offset.y() * along.x()) / turn;
    const double share = (offset.x() * end.outward.y() - offset.y() * end.outward.x()) / turn;
    if (distance <= 0 || distance > reach || share < -0.02 || share > 1.02) continue;
    if (!nearest || distance < *nearest) nearest = distance;
  }
  return nearest;
}

// The nearest end that faces this one in line.
std::optional<int> FacingEnd(const std::vector<FreeEnd>& ends, std::size_t index, double reach) {
  constexpr double kFacing = -0.98;  // the cosine of 168 degrees
  const FreeEnd& end = ends[index];
  std::optional<int> best;
  double nearest = reach;
  for (std::size_t j = 0; j < ends.size(); ++j) {
    if (j == index || end.outward.dot(ends[j].outward) > kFacing) continue;
    const Vector2d gap = ends[j].point - end.point;
    const double along = gap.dot(end.outward);
    const double aside = std::abs(gap.x() * end.outward.y() - gap.y() * end.outward.x());
    const double loose = std::max(2.0, 0.6 * std::max(end.thickness, ends[j].thickness));
    if (along <= 0 || along > nearest || aside > loose) continue;
    nearest = along;
    best = static_cast<int>(j);
  }
  return best;
}

std::vector<Opening> OpeningsOf(const prior::PlanGraph& plan, const std::vector<FreeEnd>& ends, double reach) {
  std::vector<Opening> openings;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const std::optional<double> hit = FirstHit(plan, ends[i], reach);
    const std::optional<int> facing = FacingEnd(ends, i, hit ? std::min(reach, *hit) : reach);
    if (facing && *facing < static_cast<int>(i)) continue;  // found from the other end
    if (facing) {
      openings.push_back({static_cast<int>(i), *facing, ends[i].point, ends[*facing].point});
    } else if (hit) {
      openings.push_back({static_cast<int>(i), -1, ends[i].point, ends[i].point + *hit * ends[i].outward});
    }
  }
  return openings;
}

// The width that most openings have: that with the most others within a quarter of it.
double UsualWidth(const std::vector<Opening>& openings) {
  double usual = 0;
  int most = 0;
  for (const Opening& opening : openings) {
    const auto like = [&](const Opening& other) {
      return std::abs(std::log(other.width() / opening.width())) < std::log(1.25);
    };
    const int count = static_cast<int>(std::count_if(openings.begin(), openings.end(), like));
    if (count > most) most = count, usual = opening.width();
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
