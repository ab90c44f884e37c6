// SPDX-License-Identifier: Apache-2.0
#include "core/prior/plan/planar.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "core/prior/plan/plan_check.h"
#include "core/prior/plan/segment_grid.h"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;

double CrossOf(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double MeanWallLength(const PlanGraph& plan) {
  return plan.walls.empty() ? 1.0 : WallLength(plan) / static_cast<double>(plan.walls.size());
}

SegmentGrid GridOfWalls(const PlanGraph& plan, double reach) {
  SegmentGrid grid(std::max(reach, MeanWallLength(plan) / 2));
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    const PlanWall& wall = plan.walls[i];
    grid.Add(static_cast<int>(i), plan.corners[wall.from].point, plan.corners[wall.to].point);
  }
  return grid;
}

SegmentGrid GridOfCorners(const PlanGraph& plan, double weld) {
  SegmentGrid grid(std::max(weld, 1e-9));
  for (std::size_t i = 0; i < plan.corners.size(); ++i) {
    grid.Add(static_cast<int>(i), plan.corners[i].point, plan.corners[i].point);
  }
  return grid;
}

// Corners that are one get the mean of their places.
void WeldCorners(PlanGraph& plan, double weld) {
  const std::size_t count = plan.corners.size();
  const SegmentGrid grid = GridOfCorners(plan, weld);
  std::vector<int> parent(count);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2d& p = plan.corners[i].point;
    grid.ForEachNear(p, p, [&](int j) {
      if ((plan.corners[j].point - p).norm() <= weld) parent[root(j)] = root(static_cast<int>(i));
    });
  }
  std::vector<Vector2d> sum(count, Vector2d::Zero());
  std::vector<int> members(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    sum[root(static_cast<int>(i))] += plan.corners[i].point;
    ++members[root(static_cast<int>(i))];
  }
  for (PlanWall& wall : plan.walls) {
    wall.from = root(wall.from);
    wall.to = root(wall.to);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (members[i] > 0) plan.corners[i].point = sum[i] / members[i];
  }
}

// One wall for each pair of corners, no wall of no length, no corner without a wall.
void DropRepeated(PlanGraph& plan) {
  std::map<std::pair<int, int>, PlanWall> walls;
  for (const PlanWall& wall : plan.walls) {
    const Vector2d along = plan.corners[wall.to].point - plan.corners[wall.from].point;
    if (wall.from == wall.to || !(along.norm() > 0)) continue;
    const auto [place, added] = walls.try_emplace(std::minmax(wall.from, wall.to), wall);
    if (added) continue;
    place->second.thickness = std::max(place->second.thickness, wall.thickness);
    place->second.confidence = std::max(place->second.confidence, wall.confidence);
  }
  std::vector<int> number(plan.corners.size(), -1);
  std::vector<PlanCorner> corners;
  const auto keep = [&](int corner) {
    if (number[corner] < 0) {
      number[corner] = static_cast<int>(corners.size());
      corners.push_back(plan.corners[corner]);
    }
    return number[corner];
  };
  plan.walls.clear();
  for (auto& [ends, wall] : walls) {
    wall.from = keep(wall.from);
    wall.to = keep(wall.to);
    plan.walls.push_back(wall);
  }
  plan.corners = std::move(corners);
}

// Where a wall is to be cut: shares of its length with the corner there.
using Cuts = std::vector<std::vector<std::pair<double, int>>>;

// Corners near the middle of a wall that is not theirs.
void FindTouches(const PlanGraph& plan, const SegmentGrid& grid, double weld, Cuts& cuts) {
  for (std::size_t c = 0; c < plan.corners.size(); ++c) {
    const Vector2d& p = plan.corners[c].point;
    const int corner = static_cast<int>(c);
    std::vector<int> near;
    grid.ForEachNear(p, p, [&](int id) { near.push_back(id); });
    for (const int id : near) {
      const PlanWall& wall = plan.walls[id];
      if (wall.from == corner || wall.to == corner) continue;
      const Vector2d& a = plan.corners[wall.from].point;
      const Vector2d along = plan.corners[wall.to].point - a;
      const double share = (p - a).dot(along) / along.squaredNorm();
      if (share <= 0 || share >= 1 || (a + share * along - p).norm() > weld) continue;
      cuts[id].emplace_back(share, corner);
    }
  }
}

// Walls that cross away from their ends get a common corner there; up to kMostWalls, after which there are too many
// walls.
void FindCrossings(PlanGraph& plan, const SegmentGrid& grid, double weld, Cuts& cuts) {
  const std::size_t count = plan.walls.size();
  std::size_t crossings = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const PlanWall one = plan.walls[i];
    const Vector2d a = plan.corners[one.from].point, along = plan.corners[one.to].point - a;
    std::vector<int> near;
    grid.ForEachNear(a, a + along, [&](int id) { near.push_back(id); });
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    for (const int id : near) {
      if (id <= static_cast<int>(i)) continue;
      const PlanWall other = plan.walls[id];
      const Vector2d b = plan.corners[other.from].point, across = plan.corners[other.to].point - b;
      const double turn = CrossOf(along, across);
      if (std::abs(turn) < 1e-9 * along.norm() * across.norm()) continue;
      const double s = CrossOf(b - a, across) / turn, t = CrossOf(b - a, along) / turn;
      const double s_end = weld / along.norm(), t_end = weld / across.norm();
      if (s <= s_end || s >= 1 - s_end || t <= t_end || t >= 1 - t_end) continue;
      if (++crossings > kMostWalls) return;
      const int corner = static_cast<int>(plan.corners.size());
      plan.corners.push_back({a + s * along});
      cuts[i].emplace_back(s, corner);
      cuts[id].emplace_back(t, corner);
    }
  }
}

// Whether anything was cut.
bool CutWalls(PlanGraph& plan, double weld) {
  Cuts cuts(plan.walls.size());
  const SegmentGrid grid = GridOfWalls(plan, weld);
  FindTouches(plan, grid, weld, cuts);
  FindCrossings(plan, grid, weld, cuts);
  std::vector<PlanWall> pieces;
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    std::sort(cuts[i].begin(), cuts[i].end());
    PlanWall piece = plan.walls[i];
    for (const auto& [share, corner] : cuts[i]) {
      piece.to = corner;
      pieces.push_back(piece);
      piece.from = corner;
    }
    piece.to = plan.walls[i].to;
    pieces.push_back(piece);
  }
  const bool any = pieces.size() > plan.walls.size();
  plan.walls = std::move(pieces);
  return any;
}

}  // namespace

PlanGraph Planarise(const PlanGraph& plan, double weld) {
  PlanGraph planar = plan;
  WeldCorners(planar, weld);
  DropRepeated(planar);
  constexpr int kMostRounds = 8;  // a cut moves walls by up to `weld`, which may make others touch
  for (int round = 0; round < kMostRounds && CutWalls(planar, weld); ++round) {
    if (planar.walls.size() > kMostWalls) break;
    WeldCorners(planar, weld * 0.5);
    DropRepeated(planar);
  }
  return planar;
}

double JoinDistance(const PlanGraph& plan) {
  constexpr double kMetres = 0.05, kShare = 5e-4, kMostShare = 0.01;
  const double diagonal = DiagonalOf(plan);
  const double distance = plan.metres_per_unit ? kMetres / *plan.metres_per_unit : kShare * diagonal;
  return std::min(distance, kMostShare * diagonal);
}

bool IsCrowded(const PlanGraph& plan, double weld) {
  constexpr double kMostPairs = 1e9;
  if (GridOfWalls(plan, weld).CountPairs() > kMostPairs) return true;
  return GridOfCorners(plan, weld).CountPairs() > kMostPairs;
}

bool IsPlanar(const PlanGraph& plan) {
  const SegmentGrid grid = GridOfWalls(plan, 1e-6);
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    const PlanWall& one = plan.walls[i];
    const Vector2d& a = plan.corners[one.from].point;
    const Vector2d along = plan.corners[one.to].point - a;
    bool planar = true;
    grid.ForEachNear(a, a + along, [&](int id) {
      if (id <= static_cast<int>(i)) return;
      const PlanWall& other = plan.walls[id];
      const Vector2d& b = plan.corners[other.from].point;
      const Vector2d across = plan.corners[other.to].point - b;
      const double turn = CrossOf(along, across);
      constexpr double kEnd = 1e-6;
      if (std::abs(turn) > 1e-9 * along.norm() * across.norm()) {
        const double s = CrossOf(b - a, across) / turn, t = CrossOf(b - a, along) / turn;
        if (s > kEnd && s < 1 - kEnd && t > -kEnd && t < 1 + kEnd) planar = false;
        if (t > kEnd && t < 1 - kEnd && s > -kEnd && s < 1 + kEnd) planar = false;
        return;
      }
      if (std::abs(CrossOf(b - a, along)) > 1e-6 * along.norm()) return;
      const double from = (b - a).dot(along) / along.squaredNorm();
      const double to = (b + across - a).dot(along) / along.squaredNorm();
      if (std::min(std::max(from, to), 1.0) - std::max(std::min(from, to), 0.0) > kEnd) planar = false;
    });
    if (!planar) return false;
  }
  return true;
}

}  // namespace enfilade::prior
