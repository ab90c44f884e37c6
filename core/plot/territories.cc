// SPDX-License-Identifier: Apache-2.0
#include "core/plot/territories.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <queue>
#include <tuple>
#include <utility>

namespace enfilade::plot {
namespace {

constexpr int kNone = -1;
constexpr double kDoorRadius = 0.8;  // m: ground around a door that ways do not lead through
constexpr double kFree = 0.5;        // probability of occupancy below which ground is free
constexpr double kMostCells = 4e6;   // of the lattice; larger scenes get a coarser one

// The scene in square cells. The outermost ones are outside of all rasters.
class Lattice {
 public:
  explicit Lattice(const std::vector<DrivenRaster>& rasters) {
    bool first = true;
    Eigen::Vector2d high = Eigen::Vector2d::Zero();
    for (const DrivenRaster& driven : rasters) {
      const grid::GridGeometry& geometry = driven.raster.grid.geometry;
      resolution_ = first ? geometry.resolution : std::min(resolution_, geometry.resolution);
      for (const double x : {0.0, geometry.width * geometry.resolution}) {
        for (const double y : {0.0, geometry.height * geometry.resolution}) {
          const Eigen::Vector2d corner = driven.raster.T_scene_map * (geometry.T_map_grid * Eigen::Vector2d(x, y));
          low_ = first ? corner : Eigen::Vector2d(low_.cwiseMin(corner));
          high = first ? corner : Eigen::Vector2d(high.cwiseMax(corner));
          first = false;
        }
      }
    }
    const Eigen::Vector2d size = high - low_;
    resolution_ = std::max(resolution_, std::sqrt(size.x() * size.y() / kMostCells));
    low_ -= Eigen::Vector2d::Constant(resolution_);
    width_ = static_cast<int>(std::ceil(size.x() / resolution_)) + 2;
    height_ = static_cast<int>(std::ceil(size.y() / resolution_)) + 2;
  }

  std::size_t count() const { return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_); }

  // kNone: outside, or one of the outermost.
  std::int64_t IndexAt(const Eigen::Vector2d& p_scene) const {
    const Eigen::Vector2d cell = (p_scene - low_) / resolution_;
    if (!(cell.x() >= 1.0 && cell.y() >= 1.0 && cell.x() < width_ - 1 && cell.y() < height_ - 1)) return kNone;
    return static_cast<std::int64_t>(cell.y()) * width_ + static_cast<std::int64_t>(cell.x());
  }

  Eigen::Vector2d CentreOf(std::int64_t index) const {
    const Eigen::Vector2d cell(static_cast<double>(index % width_), static_cast<double>(index / width_));
    return low_ + resolution_ * (cell + Eigen::Vector2d(0.5, 0.5));
  }

  // Those inside whose centres are that near to a point.
  std::vector<std::int64_t> Within(double radius, const Eigen::Vector2d& p_scene) const {
    std::vector<std::int64_t> indices;
    for (double y = -radius; y <= radius; y += resolution_) {
      for (double x = -radius; x <= radius; x += resolution_) {
        const std::int64_t index = IndexAt(p_scene + Eigen::Vector2d(x, y));
        if (index != kNone && (CentreOf(index) - p_scene).norm() <= radius) indices.push_back(index);
      }
    }
    return indices;
  }

  bool IsOutermost(std::int64_t index) const {
    const std::int64_t column = index % width_;
    const std::int64_t row = index / width_;
    return column == 0 || row == 0 || column == width_ - 1 || row == height_ - 1;
  }

  // The eight neighbours, the straight ones first.
  std::array<std::int64_t, 8> StepsToNeighbours() const {
    return {-1, 1, -width_, width_, -width_ - 1, -width_ + 1, width_ - 1, width_ + 1};
  }

 private:
  double resolution_ = 1.0;  // m
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
  std::int64_t width_ = 0;
  std::int64_t height_ = 0;
};

std::uint8_t CellAt(const SceneRaster& raster, const Pose2& T_grid_scene, const Eigen::Vector2d& p_scene) {
  const Eigen::Vector2d cell = T_grid_scene * p_scene / raster.grid.geometry.resolution;
  const auto column = static_cast<int>(std::floor(cell.x()));
  const auto row = static_cast<int>(std::floor(cell.y()));
  if (!raster.grid.geometry.contains(column, row)) return grid::kUnknownCell;
  return raster.grid.cells[raster.grid.geometry.index(column, row)];
}

class Territories {
 public:
  Territories(const std::vector<DrivenRaster>& rasters, const std::vector<Eigen::Vector2d>& doors)
      : rasters_(rasters), lattice_(rasters), owners_(lattice_.count(), kNone), is_door_(lattice_.count(), 0) {
    for (const Eigen::Vector2d& door : doors) {
      for (const std::int64_t index : lattice_.Within(kDoorRadius, door)) {
        is_door_[static_cast<std::size_t>(index)] = 1;
      }
    }
    for (const DrivenRaster& driven : rasters) {
      T_grid_scene_.push_back(Inverse(driven.raster.T_scene_map * driven.raster.grid.geometry.T_map_grid));
    }
  }

  // Over free ground from the drives, and then over whatever else is known beside it, also through doors.
  void Grow() {
    for (std::size_t i = 0; i < rasters_.size(); ++i) {
      for (const Eigen::Vector2d& p : rasters_[i].drives) Reach(0.0, lattice_.IndexAt(p), static_cast<int>(i));
    }
    Spread(true);
    for (std::size_t index = 0; index < owners_.size(); ++index) {
      if (owners_[index] != kNone) open_.push({0.0, static_cast<std::int64_t>(index), owners_[index]});
    }
    Spread(false);
  }

  // Leaves the raster's cells at places that no other one has.
  void Cut(int raster, grid::OccupancyGrid& grid) const {
    const Pose2 T_scene_grid = Inverse(T_grid_scene_[static_cast<std::size_t>(raster)]);
    for (int row = 0; row < grid.geometry.height; ++row) {
      for (int column = 0; column < grid.geometry.width; ++column) {
        const Eigen::Vector2d p_grid = grid.geometry.resolution * Eigen::Vector2d(column + 0.5, row + 0.5);
        const std::int64_t index = lattice_.IndexAt(T_scene_grid * p_grid);
        if (index == kNone) continue;
        const int owner = owners_[static_cast<std::size_t>(index)];
        if (owner != kNone && owner != raster) grid.cells[grid.geometry.index(column, row)] = grid::kUnknownCell;
      }
    }
  }

 private:
  struct Front {
    double length;  // cells from the drives
    std::int64_t index;
    int owner;

    friend bool operator>(const Front& a, const Front& b) {
      return std::tie(a.length, a.owner, a.index) > std::tie(b.length, b.owner, b.index);
    }
  };

  void Reach(double length, std::int64_t index, int owner) {
    if (index != kNone && owners_[static_cast<std::size_t>(index)] == kNone) open_.push({length, index, owner});
  }

  bool Knows(int owner, std::int64_t index, bool only_free) const {
    const auto raster = static_cast<std::size_t>(owner);
    const std::uint8_t cell = CellAt(rasters_[raster].raster, T_grid_scene_[raster], lattice_.CentreOf(index));
    return cell != grid::kUnknownCell && (!only_free || grid::ProbabilityOfCell(cell) < kFree);
  }

  void Spread(bool only_free) {
    const std::array<std::int64_t, 8> steps = lattice_.StepsToNeighbours();
    while (!open_.empty()) {
      const Front front = open_.top();
      open_.pop();
      int& owner = owners_[static_cast<std::size_t>(front.index)];
      if (owner != kNone && owner != front.owner) continue;
      if (owner == kNone) {
        owner = front.owner;
      } else if (only_free || front.length > 0.0) {
        continue;
      }
      if (only_free && is_door_[static_cast<std::size_t>(front.index)] != 0) continue;
      for (std::size_t i = 0; i < steps.size(); ++i) {
        const std::int64_t next = front.index + steps[i];
        if (lattice_.IsOutermost(next) || !Knows(front.owner, next, only_free)) continue;
        Reach(front.length + (i < 4 ? 1.0 : std::numbers::sqrt2), next, front.owner);
      }
    }
  }

  const std::vector<DrivenRaster>& rasters_;
  const Lattice lattice_;
  std::vector<Pose2> T_grid_scene_;
  std::vector<int> owners_;  // of each cell of the lattice: the index of a raster
  std::vector<std::uint8_t> is_door_;
  std::priority_queue<Front, std::vector<Front>, std::greater<>> open_;
};

}  // namespace

std::vector<SceneRaster> CutToTerritories(std::vector<DrivenRaster> rasters,
                                          const std::vector<Eigen::Vector2d>& doors) {
  std::map<int, std::vector<DrivenRaster>> by_level;
  for (DrivenRaster& driven : rasters) by_level[driven.level].push_back(std::move(driven));
  std::vector<SceneRaster> cut;
  for (const auto& [level, of_level] : by_level) {
    Territories territories(of_level, doors);
    territories.Grow();
    for (std::size_t i = 0; i < of_level.size(); ++i) {
      cut.push_back(of_level[i].raster);
      territories.Cut(static_cast<int>(i), cut.back().grid);
    }
  }
  return cut;
}

}  // namespace enfilade::plot
