// SPDX-License-Identifier: Apache-2.0
#include "core/grid/wall_agreement.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/grid/distance_field.h"

namespace enfilade::grid {
namespace {

constexpr double kWallFrom = 0.65;
constexpr double kFreeUpTo = 0.25;

bool IsWall(std::uint8_t cell) { return cell != kUnknownCell && ProbabilityOfCell(cell) >= kWallFrom; }
bool IsFree(std::uint8_t cell) { return cell != kUnknownCell && ProbabilityOfCell(cell) <= kFreeUpTo; }

// Counts the walls of `a` in `b`.
void CountWalls(const OccupancyGrid& a, const OccupancyGrid& b, double tolerance, WallAgreement& agreement) {
  const GridGeometry& in = b.geometry;
  std::vector<std::uint8_t> walls(b.cells.size());
  std::transform(b.cells.begin(), b.cells.end(), walls.begin(), IsWall);
  const DistanceField to_wall = DistancesTo(walls, in.width, in.height);
  const auto most = static_cast<float>(tolerance / in.resolution);
  const Pose2 T_b_a = Between(in.T_map_grid, a.geometry.T_map_grid);
  for (int row = 0; row < a.geometry.height; ++row) {
    for (int column = 0; column < a.geometry.width; ++column) {
      if (!IsWall(a.cells[a.geometry.index(column, row)])) continue;
      const Eigen::Vector2d centre = a.geometry.resolution * Eigen::Vector2d(column + 0.5, row + 0.5);
      const Eigen::Vector2d p = T_b_a * centre / in.resolution;
      const int x = static_cast<int>(std::floor(p.x()));
      const int y = static_cast<int>(std::floor(p.y()));
      if (!in.contains(x, y)) continue;
      const std::size_t cell = in.index(x, y);
      if (to_wall.distance[cell] <= most) {
        ++agreement.matched;
      } else if (IsFree(b.cells[cell])) {
        ++agreement.contradicted;
      }
    }
  }
}

}  // namespace

double WallAgreement::contradicted_share() const {
  const std::int64_t all = matched + contradicted;
  return all > 0 ? static_cast<double>(contradicted) / static_cast<double>(all) : 0.0;
}

WallAgreement CompareWalls(const OccupancyGrid& a, const OccupancyGrid& b, double tolerance) {
  WallAgreement agreement;
  if (a.cells.empty() || b.cells.empty()) return agreement;
  CountWalls(a, b, tolerance, agreement);
  CountWalls(b, a, tolerance, agreement);
  return agreement;
}

}  // namespace enfilade::grid
