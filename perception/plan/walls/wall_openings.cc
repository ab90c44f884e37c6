// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/walls/wall_openings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

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
  double length = 0;     // of the wall
  bool goes_on = false;  // whether another wall goes on straight at the wall's other end
};

double CrossOf(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// In a drawing by hand, jambs lie this far aside of where they are, of the width of their door.
constexpr double kAside = 0.2;

// How far an end points aside of a gap, squared and in variances: the gap turns by both of its ends, and the wall by
// those of its own.
double SquaredTurn(const FreeEnd& end, const Vector2d& gap) {
  const double width = gap.norm();
  const double angle = std::acos(std::clamp(end.outward.dot(gap) / width, -1.0, 1.0));
  const double of_gap = std::sqrt(2.0) * kAside, of_wall = of_gap * width / end.length;
  constexpr double kWidest = 0.5;  // rad: a stub does not point anywhere
  return angle * angle / std::min(of_gap * of_gap + of_wall * of_wall, kWidest * kWidest);
}

constexpr double kMostSquaredTurn = 4;

class OpeningSearch {
 public:
  OpeningSearch(const prior::PlanGraph& plan, double reach)
      : plan_(plan),
        reach_(reach),
        is_end_(plan.corners.size(), false),
        ends_grid_(kCell * reach),
        walls_grid_(kCell * reach) {
    std::vector<std::vector<int>> at(plan.corners.size());
    for (int i = 0; i < static_cast<int>(plan.walls.size()); ++i) {
      at[plan.walls[i].from].push_back(i);
      at[plan.walls[i].to].push_back(i);
      walls_grid_.Add(i, From(i), To(i));
    }
    for (int i = 0; i < static_cast<int>(plan.walls.size()); ++i) {
      AddEnd(at, i, plan.walls[i].from, plan.walls[i].to);
      AddEnd(at, i, plan.walls[i].to, plan.walls[i].from);
    }
  }

  bool IsCrowded() const {
    constexpr double kMostPairs = 3e7;
    return ends_grid_.CountPairs() > kMostPairs || walls_grid_.CountPairs() > kMostPairs;
  }

  std::vector<Opening> Find() {
    for (int i = 0; i < static_cast<int>(ends_.size()); ++i) {
      FindFacing(i);
      FindSides(ends_[i]);
    }
    return std::move(openings_);
  }

 private:
  static constexpr double kAtCorner = 0.3;  // of the gap
  static constexpr double kCell = 0.75;     // of the reach: as far aside as an end may point

  Vector2d From(int wall) const { return plan_.corners[plan_.walls[wall].from].point; }
  Vector2d To(int wall) const { return plan_.corners[plan_.walls[wall].to].point; }

  void AddEnd(const std::vector<std::vector<int>>& at, int wall, int corner, int base) {
    if (at[corner].size() != 1) return;
    const Vector2d point = plan_.corners[corner].point, begin = plan_.corners[base].point;
    FreeEnd end{corner, wall, point, (point - begin).normalized(), (point - begin).norm()};
    for (const int other : at[base]) {
      constexpr double kStraight = 0.9;  // the cosine of 26 degrees
      const int far = plan_.walls[other].from == base ? plan_.walls[other].to : plan_.walls[other].from;
      const Vector2d back = (begin - plan_.corners[far].point).normalized();
      if (other != wall && back.dot(end.outward) > kStraight) end.goes_on = true;
    }
    is_end_[corner] = true;
    ends_grid_.Add(static_cast<int>(ends_.size()), point, point);
    ends_.push_back(end);
  }

  template <typename Visit>
  void ForEachOnce(const prior::SegmentGrid& grid, const FreeEnd& end, const Visit& visit) {
    near_.clear();
    grid.ForEachNear(end.point, end.point + reach_ * end.outward, [&](int id) { near_.push_back(id); });
    std::sort(near_.begin(), near_.end());
    near_.erase(std::unique(near_.begin(), near_.end()), near_.end());
    for (const int id : near_) visit(id);
  }

  bool IsAhead(const FreeEnd& end, const Vector2d& gap) const {
    return end.outward.dot(gap) > 0 && gap.norm() <= reach_ && SquaredTurn(end, gap) <= kMostSquaredTurn;
  }

  void FindFacing(int index) {
    const FreeEnd& end = ends_[index];
    ForEachOnce(ends_grid_, end, [&](int j) {
      const FreeEnd& other = ends_[j];
      if (j <= index || other.wall == end.wall) return;
      const Vector2d gap = other.point - end.point;
      if (!IsAhead(end, gap) || !IsAhead(other, -gap) || IsCrossed(end, gap)) return;
      openings_.push_back(
          {end.corner, other.corner, end.point, other.point, SquaredTurn(end, gap) + SquaredTurn(other, -gap)});
    });
  }

  // Straight on to a wall's side, or past the end of that wall, to its end.
  void FindSides(const FreeEnd& end) {
    ForEachOnce(walls_grid_, end, [&](int i) {
      const Vector2d a = From(i), along = To(i) - a;
      const double turn = CrossOf(end.outward, along);
      constexpr double kLeastTurn = 0.3;  // the sine of the angle between wall and side
      if (i == end.wall || std::abs(turn) < kLeastTurn * along.norm()) return;
      if (CrossOf(a - end.point, along) / turn <= 0) return;
      const double share = std::clamp(CrossOf(a - end.point, end.outward) / turn, 0.0, 1.0);
      const Vector2d gap = a + share * along - end.point;
      if (!IsAhead(end, gap) || IsCrossed(end, gap)) return;
      const double to_corner = std::min(share, 1 - share) * along.norm();
      const int corner = share < 0.5 ? plan_.walls[i].from : plan_.walls[i].to;
      const bool at_end = is_end_[corner] && to_corner <= kAtCorner * gap.norm();
      openings_.push_back({end.corner, at_end ? corner : -1, end.point, end.point + gap,
                           SquaredTurn(end, gap) + StrangenessOfSide(end, to_corner / gap.norm())});
    });
  }

  // A gap to a wall's side is more often none of a door than one between two ends: also walls that end in a room point
  // at something. Where a door is beside a corner, the side has that corner there, and the door is in one line with
  // more wall than the stub that leaves another wall.
  static double StrangenessOfSide(const FreeEnd& end, double widths_to_corner) {
    constexpr double kSide = 2, kPlainSide = 3, kStub = 2;
    return kSide + (widths_to_corner > kAtCorner ? kPlainSide : 0) + (end.goes_on ? 0 : kStub);
  }

  bool IsCrossed(const FreeEnd& end, const Vector2d& gap) const {
    constexpr double kEnds = 0.05;  // of the gap
    bool crossed = false;
    walls_grid_.ForEachNear(end.point, end.point + gap, [&](int i) {
      if (crossed || i == end.wall) return;
      const Vector2d a = From(i), along = To(i) - a;
      const double turn = CrossOf(gap, along);
      if (turn == 0) return;
      const double at = CrossOf(a - end.point, along) / turn, share = CrossOf(a - end.point, gap) / turn;
      crossed = at > kEnds && at < 1 - kEnds && share >= 0 && share <= 1;
    });
    return crossed;
  }

  const prior::PlanGraph& plan_;
  const double reach_;
  std::vector<FreeEnd> ends_;
  std::vector<bool> is_end_;  // of each corner
  prior::SegmentGrid ends_grid_, walls_grid_;
  std::vector<int> near_;
  std::vector<Opening> openings_;
};

}  // namespace

std::vector<Opening> FindOpenings(const prior::PlanGraph& plan, double reach) {
  constexpr int kMostHalvings = 10;
  for (int i = 0; i < kMostHalvings && reach > 0 && std::isfinite(reach); ++i, reach /= 2) {
    OpeningSearch search(plan, reach);
    if (!search.IsCrowded()) return search.Find();
  }
  return {};
}

}  // namespace enfilade::perception
