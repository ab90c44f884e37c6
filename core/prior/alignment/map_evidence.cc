// SPDX-License-Identifier: Apache-2.0
#include "core/prior/alignment/map_evidence.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <unordered_map>

#include "core/grid/distance_field.h"

namespace enfilade::prior {
namespace {

constexpr double kOccupied = 0.65;        // probability
constexpr double kMostFree = 0.35;        // probability
constexpr double kNoUnknown = 0.005;      // share of the cells
constexpr double kDoorGap = 0.6;          // m, half of what counts as closed
constexpr double kLeastSpacing = 0.1;     // m
constexpr double kSurroundings = 0.5;     // m
constexpr std::size_t kFewestAround = 4;  // points within kSurroundings, else it is noise
constexpr std::size_t kMostPoints = 6000;
constexpr double kStraightEnough = 0.6;  // the two faces of a thick wall are each less straight for the other
constexpr double kBeside[] = {0.1, 0.15, 0.2, 0.25};  // m, where free ground is looked for

using grid::GridGeometry;

struct Cell {
  int column;
  int row;
};

Cell CellAt(const GridGeometry& geometry, std::size_t index) {
  const auto width = static_cast<std::size_t>(geometry.width);
  return {static_cast<int>(index % width), static_cast<int>(index / width)};
}

Eigen::Vector2d CentreOf(const GridGeometry& geometry, std::size_t index) {
  const Cell cell = CellAt(geometry, index);
  return geometry.T_map_grid *
         Eigen::Vector2d(geometry.resolution * Eigen::Vector2d(cell.column + 0.5, cell.row + 0.5));
}

std::vector<Ground> ClassesOf(const grid::OccupancyGrid& grid) {
  const std::uint8_t wall = grid::CellFromProbability(kOccupied);
  const std::uint8_t free = grid::CellFromProbability(kMostFree);
  std::vector<Ground> ground(grid.cells.size(), Ground::kUnknown);
  for (std::size_t i = 0; i < ground.size(); ++i) {
    const std::uint8_t cell = grid.cells[i];
    if (cell == grid::kUnknownCell) continue;
    if (cell >= wall) ground[i] = Ground::kWall;
    if (cell <= free) ground[i] = Ground::kFree;
  }
  return ground;
}

bool HasUnknown(const std::vector<Ground>& ground) {
  const auto unknown = std::count(ground.begin(), ground.end(), Ground::kUnknown);
  return static_cast<double>(unknown) > kNoUnknown * static_cast<double>(ground.size());
}

std::vector<float> DistancesToWalls(const std::vector<Ground>& ground, const GridGeometry& geometry) {
  std::vector<std::uint8_t> walls(ground.size());
  for (std::size_t i = 0; i < walls.size(); ++i) walls[i] = ground[i] == Ground::kWall ? 1 : 0;
  std::vector<float> distances = grid::DistancesTo(walls, geometry.width, geometry.height).distance;
  for (float& distance : distances)
    distance = std::min(kMostDistance, distance * static_cast<float>(geometry.resolution));
  return distances;
}

// Ground that can be reached from the picture's border without passing a gap of a door's width becomes unknown.
void ForgetOutside(const std::vector<float>& wall_distance, const GridGeometry& geometry, std::vector<Ground>& ground) {
  std::vector<std::uint8_t> outside(ground.size(), 0);
  std::deque<std::size_t> next;
  const auto visit = [&](int column, int row) {
    if (!geometry.contains(column, row)) return;
    const std::size_t cell = geometry.index(column, row);
    if (outside[cell] != 0 || wall_distance[cell] < kDoorGap) return;
    outside[cell] = 1;
    next.push_back(cell);
  };
  for (int column = 0; column < geometry.width; ++column) visit(column, 0), visit(column, geometry.height - 1);
  for (int row = 0; row < geometry.height; ++row) visit(0, row), visit(geometry.width - 1, row);
  while (!next.empty()) {
    const Cell cell = CellAt(geometry, next.front());
    next.pop_front();
    visit(cell.column + 1, cell.row), visit(cell.column - 1, cell.row);
    visit(cell.column, cell.row + 1), visit(cell.column, cell.row - 1);
  }
  // What lies outside, as far as a door's gap from there.
  const std::vector<float> distance = grid::DistancesTo(outside, geometry.width, geometry.height).distance;
  for (std::size_t i = 0; i < ground.size(); ++i) {
    if (ground[i] == Ground::kFree && distance[i] * geometry.resolution <= kDoorGap) ground[i] = Ground::kUnknown;
  }
}

bool IsBeside(const std::vector<Ground>& ground, const GridGeometry& geometry, std::size_t index, Ground wanted,
              int reach) {
  const Cell cell = CellAt(geometry, index);
  for (int row = cell.row - reach; row <= cell.row + reach; ++row) {
    for (int column = cell.column - reach; column <= cell.column + reach; ++column) {
      if (geometry.contains(column, row) && ground[geometry.index(column, row)] == wanted) return true;
    }
  }
  return false;
}

using Buckets = std::unordered_map<std::int64_t, std::vector<std::size_t>>;

std::int64_t BucketOf(const Eigen::Vector2d& point, double side) {
  const auto column = static_cast<std::int64_t>(std::floor(point.x() / side));
  const auto row = static_cast<std::int64_t>(std::floor(point.y() / side));
  return (column << 32) ^ (row & 0xFFFFFFFF);
}

// The mean of the cells in each square of `spacing`.
std::vector<Eigen::Vector2d> Thinned(const std::vector<Eigen::Vector2d>& points, double spacing) {
  struct Sum {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    int count = 0;
  };
  std::unordered_map<std::int64_t, std::size_t> index;
  std::vector<Sum> sums;
  for (const Eigen::Vector2d& point : points) {
    const auto [at, is_new] = index.try_emplace(BucketOf(point, spacing), sums.size());
    if (is_new) sums.emplace_back();
    sums[at->second].sum += point;
    ++sums[at->second].count;
  }
  std::vector<Eigen::Vector2d> thinned;
  thinned.reserve(sums.size());
  for (const Sum& sum : sums) thinned.push_back(sum.sum / sum.count);
  return thinned;
}

std::vector<WallPoint> WithDirections(const std::vector<Eigen::Vector2d>& points) {
  Buckets buckets;
  for (std::size_t i = 0; i < points.size(); ++i) buckets[BucketOf(points[i], kSurroundings)].push_back(i);
  std::vector<WallPoint> walls;
  for (const Eigen::Vector2d& point : points) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    std::vector<Eigen::Vector2d> around;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const auto found = buckets.find(BucketOf(point + kSurroundings * Eigen::Vector2d(dx, dy), kSurroundings));
        if (found == buckets.end()) continue;
        for (const std::size_t other : found->second) {
          if ((points[other] - point).norm() > kSurroundings) continue;
          around.push_back(points[other]);
          mean += points[other];
        }
      }
    }
    if (around.size() < kFewestAround) continue;
    mean /= static_cast<double>(around.size());
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    for (const Eigen::Vector2d& other : around) spread += (other - mean) * (other - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread);
    const double largest = axes.eigenvalues()(1);
    if (!(largest > 0)) continue;
    walls.push_back(
        {.point = point, .along = axes.eigenvectors().col(1), .straightness = 1.0 - axes.eigenvalues()(0) / largest});
  }
  return walls;
}

// By the nearest free ground: behind a wall's other face there is some, too.
Eigen::Vector2d OpenSideOf(const WallPoint& wall, const MapEvidence& evidence) {
  const Eigen::Vector2d across(-wall.along.y(), wall.along.x());
  for (const double distance : kBeside) {
    const bool left = evidence.GroundAt(wall.point + distance * across) == Ground::kFree;
    const bool right = evidence.GroundAt(wall.point - distance * across) == Ground::kFree;
    if (left && right) break;
    if (left) return across;
    if (right) return -across;
  }
  return Eigen::Vector2d::Zero();
}

}  // namespace

std::optional<std::size_t> MapEvidence::CellOf(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d cell = (T_grid_map * point) / geometry.resolution;
  const int column = static_cast<int>(std::floor(cell.x()));
  const int row = static_cast<int>(std::floor(cell.y()));
  if (!geometry.contains(column, row)) return std::nullopt;
  return geometry.index(column, row);
}

Ground MapEvidence::GroundAt(const Eigen::Vector2d& point) const {
  const std::optional<std::size_t> cell = CellOf(point);
  return cell ? ground[*cell] : Ground::kUnknown;
}

double MapEvidence::WallDistanceAt(const Eigen::Vector2d& point) const {
  const std::optional<std::size_t> cell = CellOf(point);
  return cell ? wall_distance[*cell] : kMostDistance;
}

MapEvidence EvidenceOf(const grid::OccupancyGrid& grid) {
  MapEvidence evidence;
  evidence.geometry = grid.geometry;
  const Pose2 T_grid_map = Inverse(grid.geometry.T_map_grid);
  evidence.T_grid_map = Eigen::Translation2d(T_grid_map.translation()) * Eigen::Rotation2Dd(T_grid_map.yaw);
  evidence.ground = ClassesOf(grid);
  evidence.wall_distance = DistancesToWalls(evidence.ground, grid.geometry);
  const bool beside_free = HasUnknown(evidence.ground);
  if (!beside_free) ForgetOutside(evidence.wall_distance, grid.geometry, evidence.ground);

  std::vector<Eigen::Vector2d> cells;
  for (std::size_t i = 0; i < evidence.ground.size(); ++i) {
    if (evidence.ground[i] != Ground::kWall) continue;
    const bool is_face = beside_free ? IsBeside(evidence.ground, grid.geometry, i, Ground::kFree, 2)
                                     : IsBeside(evidence.ground, grid.geometry, i, Ground::kFree, 1) ||
                                           IsBeside(evidence.ground, grid.geometry, i, Ground::kUnknown, 1);
    if (is_face) cells.push_back(CentreOf(grid.geometry, i));
  }
  evidence.spacing = std::max(kLeastSpacing, 1.5 * grid.geometry.resolution);
  std::vector<Eigen::Vector2d> points = Thinned(cells, evidence.spacing);
  while (points.size() > kMostPoints) {
    evidence.spacing *= 1.4;
    points = Thinned(cells, evidence.spacing);
  }
  evidence.walls = WithDirections(points);
  for (WallPoint& wall : evidence.walls) {
    if (wall.straightness > kStraightEnough) wall.open = OpenSideOf(wall, evidence);
  }
  return evidence;
}

}  // namespace enfilade::prior
