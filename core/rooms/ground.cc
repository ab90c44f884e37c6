// SPDX-License-Identifier: Apache-2.0
#include "core/rooms/ground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "core/geometry/pose2.h"

namespace enfilade::rooms {
namespace {

constexpr double kRobotRadius = 0.15;  // m around where a robot has been is free

void Threshold(const grid::OccupancyGrid& grid, const RoomOptions& options, GroundMap& ground) {
  std::array<Ground, 256> kinds{};
  for (int value = 1; value < 256; ++value) {
    const double probability = grid::ProbabilityOfCell(static_cast<std::uint8_t>(value));
    if (probability >= options.occupied_probability) kinds[static_cast<std::size_t>(value)] = Ground::kWall;
    if (probability <= options.free_probability) kinds[static_cast<std::size_t>(value)] = Ground::kOpen;
  }
  std::transform(grid.cells.begin(), grid.cells.end(), ground.cells.begin(),
                 [&](std::uint8_t value) { return kinds[value]; });
}

void FreeTrajectory(const grid::GridGeometry& geometry, std::span<const Eigen::Vector2d> trajectory,
                    GroundMap& ground) {
  const Pose2 T_grid_map = Inverse(geometry.T_map_grid);
  const int radius = static_cast<int>(kRobotRadius / geometry.resolution);
  for (const Eigen::Vector2d& p_map : trajectory) {
    if (!p_map.allFinite()) continue;
    const Eigen::Vector2d p = T_grid_map * p_map / geometry.resolution;
    if (p.x() < 0.0 || p.y() < 0.0 || p.x() >= geometry.width || p.y() >= geometry.height) continue;
    for (int dy = -radius; dy <= radius; ++dy) {
      for (int dx = -radius; dx <= radius; ++dx) {
        const int column = static_cast<int>(p.x()) + dx;
        const int row = static_cast<int>(p.y()) + dy;
        if (dx * dx + dy * dy <= radius * radius && ground.contains(column, row)) {
          ground.cells[ground.index(column, row)] = Ground::kOpen;
        }
      }
    }
  }
}

// Steps, up to `limit`, from the cells in `front` through those that `passable` allows; sides only. -1: not reached.
template <typename Passable>
std::vector<std::int16_t> StepsFrom(const GroundMap& ground, std::vector<std::size_t> front, int limit,
                                    Passable&& passable) {
  std::vector<std::int16_t> steps(ground.cells.size(), -1);
  for (const std::size_t cell : front) steps[cell] = 0;
  for (int step = 1; step <= limit && !front.empty(); ++step) {
    std::vector<std::size_t> next;
    const auto visit = [&](std::size_t cell) {
      if (steps[cell] >= 0 || !passable(cell)) return;
      steps[cell] = static_cast<std::int16_t>(step);
      next.push_back(cell);
    };
    for (const std::size_t cell : front) ground.VisitSides(cell, visit);
    front = std::move(next);
  }
  return steps;
}

std::vector<std::size_t> CellsOf(const GroundMap& ground, Ground kind) {
  std::vector<std::size_t> cells;
  for (std::size_t i = 0; i < ground.cells.size(); ++i) {
    if (ground.cells[i] == kind) cells.push_back(i);
  }
  return cells;
}

// Unknown cells between free ones: a morphological closing of the open ground that walls stop.
void CloseHoles(GroundMap& ground, int steps) {
  const std::vector<std::int16_t> grown = StepsFrom(ground, CellsOf(ground, Ground::kOpen), steps,
                                                    [&](std::size_t c) { return ground.cells[c] == Ground::kUnknown; });
  // The unknown cells beside those: what lies farther outside, most of a grid, comes to nothing.
  std::vector<std::size_t> outside;
  const auto add_outside = [&](std::size_t cell) {
    if (grown[cell] < 0 && ground.cells[cell] == Ground::kUnknown) outside.push_back(cell);
  };
  for (std::size_t i = 0; i < grown.size(); ++i) {
    if (grown[i] > 0) ground.VisitSides(i, add_outside);
  }
  const std::vector<std::int16_t> back =
      StepsFrom(ground, std::move(outside), steps, [&](std::size_t c) { return grown[c] > 0; });
  for (std::size_t i = 0; i < grown.size(); ++i) {
    if (grown[i] > 0 && back[i] < 0) ground.cells[i] = Ground::kOpen;
  }
}

struct Extent {
  int min_column = std::numeric_limits<int>::max();
  int min_row = std::numeric_limits<int>::max();
  int max_column = -1;
  int max_row = -1;

  void Add(int column, int row) {
    min_column = std::min(min_column, column);
    min_row = std::min(min_row, row);
    max_column = std::max(max_column, column);
    max_row = std::max(max_row, row);
  }
  int length() const { return std::max(max_column - min_column, max_row - min_row) + 1; }
};

// The cells that `belongs` allows and that no group has yet, in rows that are longer by a margin on all sides: looking
// around a cell needs no bounds, and takes one read a row.
class CellsLeft {
 public:
  static constexpr int kReach = 2;

  template <typename Belongs>
  CellsLeft(const GroundMap& ground, Belongs&& belongs)
      : width_(static_cast<std::size_t>(ground.width) + 2 * kReach),
        left_(width_ * (static_cast<std::size_t>(ground.height) + 2 * kReach), 0) {
    for (int row = 0; row < ground.height; ++row) {
      for (int column = 0; column < ground.width; ++column) {
        left_[index(column, row)] = belongs(ground.index(column, row)) ? 1 : 0;
      }
    }
  }

  // Whether the cell was there.
  bool Take(int column, int row) {
    std::uint8_t& left = left_[index(column, row)];
    if (left == 0) return false;
    left = 0;
    return true;
  }

  // Takes all cells up to kReach away, and calls take(column, row) for each.
  template <typename Call>
  void TakeAround(int column, int row, Call&& take) {
    for (int y = row - kReach; y <= row + kReach; ++y) {
      std::uint8_t* first = &left_[index(column - kReach, y)];
      std::uint32_t four = 0;  // most rows have none left
      std::memcpy(&four, first, sizeof(four));
      if (four == 0 && first[kSide - 1] == 0) continue;
      for (int i = 0; i < kSide; ++i) {
        if (std::exchange(first[i], std::uint8_t{0}) != 0) take(column - kReach + i, y);
      }
    }
  }

 private:
  static constexpr int kSide = 2 * kReach + 1;

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row + kReach) * width_ + static_cast<std::size_t>(column + kReach);
  }

  std::size_t width_;
  std::vector<std::uint8_t> left_;
};

// Calls visit(cells, extent) for each group of cells (with gaps of up to one cell) that `belongs` allows.
template <typename Belongs, typename Visit>
void VisitGroups(const GroundMap& ground, Belongs&& belongs, Visit&& visit) {
  CellsLeft left(ground, belongs);
  std::vector<std::pair<int, int>> front;
  std::vector<std::size_t> group;
  for (int first_row = 0; first_row < ground.height; ++first_row) {
    for (int first_column = 0; first_column < ground.width; ++first_column) {
      if (!left.Take(first_column, first_row)) continue;
      group.clear();
      front.assign(1, {first_column, first_row});
      Extent extent;
      while (!front.empty()) {
        const auto [column, row] = front.back();
        front.pop_back();
        extent.Add(column, row);
        group.push_back(ground.index(column, row));
        left.TakeAround(column, row, [&](int x, int y) { front.emplace_back(x, y); });
      }
      visit(group, extent);
    }
  }
}

// Marks as clutter the groups of obstacle cells that are at most `limit` cells long.
void MarkClutter(GroundMap& ground, int limit) {
  const auto solid = [&](std::size_t cell) { return !ground.IsOpen(cell); };
  VisitGroups(ground, solid, [&](const std::vector<std::size_t>& group, const Extent& extent) {
    const bool at_border = extent.min_column == 0 || extent.min_row == 0 || extent.max_column == ground.width - 1 ||
                           extent.max_row == ground.height - 1;
    if (extent.length() > limit || at_border) return;
    for (const std::size_t cell : group) ground.cells[cell] = Ground::kClutter;
  });
}

void MeasureWalls(GroundMap& ground) {
  ground.extent.assign(ground.cells.size(), 0);
  const auto wall = [&](std::size_t cell) { return ground.cells[cell] == Ground::kWall; };
  VisitGroups(ground, wall, [&](const std::vector<std::size_t>& group, const Extent& extent) {
    const auto length = static_cast<std::uint16_t>(std::min(extent.length(), 65535));
    for (const std::size_t cell : group) ground.extent[cell] = length;
  });
}

// By the second moments of the wall cells around each wall cell.
void MeasureDirections(GroundMap& ground) {
  constexpr double kReach = 0.35;     // m
  constexpr double kStraight = 0.75;  // anisotropy: 0 round, 1 a line
  const int reach = std::max(2, static_cast<int>(kReach / ground.resolution));
  ground.direction.assign(ground.cells.size(), 0);
  for (int row = reach; row + reach < ground.height; ++row) {
    for (int column = reach; column + reach < ground.width; ++column) {
      if (ground.cells[ground.index(column, row)] != Ground::kWall) continue;
      double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
      for (int dy = -reach; dy <= reach; ++dy) {
        const Ground* const cells = &ground.cells[ground.index(column, row + dy)];
        int walls = 0, along = 0, squares = 0;
        for (int dx = -reach; dx <= reach; ++dx) {  // without a branch: this is most of the work
          const int wall = cells[dx] == Ground::kWall ? 1 : 0;
          walls += wall;
          along += wall * dx;
          squares += wall * dx * dx;
        }
        n += walls;
        x += along;
        y += walls * dy;
        xx += squares;
        xy += along * dy;
        yy += walls * dy * dy;
      }
      const double vx = xx / n - x * x / (n * n);
      const double vy = yy / n - y * y / (n * n);
      const double vxy = xy / n - x * y / (n * n);
      const double difference = std::hypot(vx - vy, 2.0 * vxy);
      if (difference < kStraight * (vx + vy)) continue;
      const double degrees = 0.5 * std::atan2(2.0 * vxy, vx - vy) / kDegree;  // -90..90
      ground.direction[ground.index(column, row)] =
          static_cast<std::uint8_t>(1 + (static_cast<int>(std::lround(degrees)) + 180) % 180);
    }
  }
}

}  // namespace

GroundMap ReadGround(const grid::OccupancyGrid& grid, const RoomOptions& options,
                     std::span<const Eigen::Vector2d> trajectory) {
  GroundMap ground{grid.geometry.width, grid.geometry.height, grid.geometry.resolution, {}, {}, {}};
  ground.cells.resize(grid.cells.size());
  Threshold(grid, options, ground);
  FreeTrajectory(grid.geometry, trajectory, ground);
  CloseHoles(ground, static_cast<int>(std::lround(options.hole / 2.0 / ground.resolution)));
  MarkClutter(ground, static_cast<int>(options.clutter / ground.resolution));
  MeasureWalls(ground);
  MeasureDirections(ground);
  return ground;
}

DistanceField DistancesToWalls(const GroundMap& ground) {
  std::vector<std::uint8_t> obstacles(ground.cells.size());
  for (std::size_t i = 0; i < obstacles.size(); ++i) obstacles[i] = ground.IsOpen(i) ? 0 : 1;
  return grid::DistancesTo(obstacles, ground.width, ground.height);
}

Eigen::Vector2d ToCells(const grid::GridGeometry& geometry, const Eigen::Vector2d& p_map) {
  const Eigen::Vector2d p = Inverse(geometry.T_map_grid) * p_map;
  return p / geometry.resolution - Eigen::Vector2d(0.5, 0.5);
}

Eigen::Vector2d ToMap(const grid::GridGeometry& geometry, const Eigen::Vector2d& cells) {
  const Eigen::Vector2d p = (cells + Eigen::Vector2d(0.5, 0.5)) * geometry.resolution;
  return geometry.T_map_grid * p;
}

}  // namespace enfilade::rooms
