// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/binary.h"
#include "core/geometry/pose2.h"
#include "core/grid/bresenham.h"
#include "core/grid/occupancy_grid.h"
#include "core/grid/scan_rays.h"

namespace enfilade::grid {

// The inverse sensor model and the bounds of belief. Defaults: Hornung et al., "OctoMap", Autonomous Robots 2013.
struct LogOddsOptions {
  double p_hit = 0.7;     // occupied, given one scan that ends in the cell
  double p_miss = 0.4;    // occupied, given one scan that passes through the cell
  double p_min = 0.1192;  // lower bound of belief, so that a few scans suffice to register a chair that was put back
  double p_max = 0.971;   // upper bound of belief
  // A scan that would make the window larger than this is refused.
  std::int64_t max_cells = std::int64_t{1} << 28;

  // INVALID_ARGUMENT naming the option unless 0 < p_min < p_miss < 0.5 < p_hit < p_max < 1 and max_cells > 0.
  absl::Status Validate() const;
};

// An occupancy grid in log-odds that grows with the scans cast into it (Thrun, Burgard, Fox, "Probabilistic Robotics",
// 2005, table 9.1, with prior 0.5). Cells lie on the lattice of its frame: cell (column, row) covers
// [column, column + 1) x [row, row + 1) times the resolution; indices may be negative. Only a window of the lattice is
// stored, densely; cells outside it are unknown.
//
// A scan changes each cell at most once, and a hit outweighs any number of misses: beams that graze a wall do not erase
// it. All arithmetic is integer: the same rays in the same order give the same cells on every machine.
//
// A value type; not thread-safe.
class LogOddsGrid {
 public:
  // Log-odds are stored in units of 1/1000.
  static constexpr double kUnitsPerLogOdds = 1000.0;
  // The value of a cell that no scan has touched. Not the same as even odds.
  static constexpr std::int16_t kUnknown = INT16_MIN;

  // `resolution`: the side of a cell in m, positive; `options` valid.
  LogOddsGrid(double resolution, const LogOddsOptions& options);

  // Casts one scan. INVALID_ARGUMENT: a coordinate is not finite. RESOURCE_EXHAUSTED: the window would grow beyond
  // max_cells. On error the grid is unchanged.
  absl::Status Insert(const ScanRays& rays);

  double resolution() const { return resolution_; }
  // The stored window: its lowest cell, and its size.
  CellIndex window_min() const { return min_; }
  int width() const { return width_; }
  int height() const { return height_; }
  // Row-major from window_min(), rows upwards: kUnknown or log-odds in units.
  const std::vector<std::int16_t>& cells() const { return cells_; }

  // The cell of a point; the point must be finite and within +-1e9 cells.
  CellIndex CellOf(const Eigen::Vector2d& p_grid) const {
    return {static_cast<int>(std::floor(p_grid.x() / resolution_)),
            static_cast<int>(std::floor(p_grid.y() / resolution_))};
  }
  bool Contains(CellIndex cell) const {
    return cell.column >= min_.column && cell.row >= min_.row && cell.column - min_.column < width_ &&
           cell.row - min_.row < height_;
  }
  // kUnknown outside the window.
  std::int16_t ValueAt(CellIndex cell) const { return Contains(cell) ? cells_[OffsetOf(cell)] : kUnknown; }
  // 0.5 for kUnknown.
  static double ProbabilityOf(std::int16_t value) {
    return value == kUnknown ? 0.5 : 1.0 / (1.0 + std::exp(-static_cast<double>(value) / kUnitsPerLogOdds));
  }

  // Shrinks the window to the known cells and frees the working memory. More scans may follow.
  void Crop();

  // The bounding box of the known cells, as probabilities; empty (0 x 0) if no cell is known. T_map_grid is the pose of
  // this grid's frame in the map.
  OccupancyGrid ToOccupancyGrid(const Pose2& T_map_grid = {}) const;

  // A stored window: `cells` row-major, `width` x `height`, from the cell `min` on.
  struct Window {
    CellIndex min;
    int width = 0;
    int height = 0;
    std::vector<std::int16_t> cells;
  };
  // Values beyond the options' bounds are clamped. INVALID_ARGUMENT: the window has more or fewer cells than it says.
  static absl::StatusOr<LogOddsGrid> FromWindow(double resolution, const LogOddsOptions& options, Window window);

  // Window and cells, not the options.
  void Write(BinaryWriter& writer) const;
  // DATA_LOSS on bytes that Write did not write.
  static absl::StatusOr<LogOddsGrid> Read(BinaryReader& reader, const LogOddsOptions& options);

  // The same lattice, window and cells.
  friend bool operator==(const LogOddsGrid& a, const LogOddsGrid& b) {
    return a.resolution_ == b.resolution_ && a.min_ == b.min_ && a.width_ == b.width_ && a.height_ == b.height_ &&
           a.cells_ == b.cells_;
  }

 private:
  struct Box {
    CellIndex min;
    CellIndex max;  // inclusive
  };

  std::size_t OffsetOf(CellIndex cell) const {
    return static_cast<std::size_t>(cell.row - min_.row) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(cell.column - min_.column);
  }
  absl::StatusOr<Box> BoundsOf(const ScanRays& rays) const;
  absl::Status Cover(const Box& box);
  void MoveWindow(CellIndex min, int width, int height);
  Box KnownBox() const;
  void StartScan();
  void CastMisses(CellIndex from, CellIndex to);

  double resolution_;
  std::int16_t hit_;
  std::int16_t miss_;
  std::int16_t lowest_;
  std::int16_t highest_;
  std::int64_t max_cells_;

  CellIndex min_;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::int16_t> cells_;
  // For each cell the number (1..255) of the last scan that changed it, so that a scan changes a cell only once. Not
  // part of the value.
  std::vector<std::uint8_t> changed_by_;
  std::uint8_t scan_ = 0;
};

}  // namespace enfilade::grid
