// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "core/base/binary.h"
#include "core/geometry/pose2.h"
#include "core/grid/log_odds_grid.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// The occupancy map of one submap, in the submap's frame: log-odds, and for every cell in which beams ended the mean of
// their ends (as in GMapping: Grisetti, Stachniss, Burgard 2007), which locates walls much more finely than the cell
// size.
class SubmapGrid {
 public:
  struct HitMean {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();  // m, in the submap's frame
    std::int32_t count = 0;

    friend bool operator==(const HitMean&, const HitMean&) = default;
  };
  using Key = std::pair<int, int>;  // row, column
  using Hits = std::vector<std::pair<Key, HitMean>>;

  SubmapGrid(double resolution, const OccupancyOptions& options);

  // From an existing map with its cells on the lattice of their resolution (ResampleToLattice). The hit mean of an
  // occupied cell is its centre, with count 1.
  static SubmapGrid FromOccupancy(const grid::OccupancyGrid& grid, const OccupancyOptions& options);

  // Adds a scan taken at `T_submap_robot`, rays in the robot's frame. Returns the cells whose occupied state or mean
  // changed, in order. Same errors as LogOddsGrid::Insert; the grid is then unchanged.
  absl::StatusOr<std::vector<grid::CellIndex>> Insert(const Pose2& T_submap_robot, const grid::ScanRays& rays);

  const grid::LogOddsGrid& log_odds() const { return log_odds_; }
  double resolution() const { return log_odds_.resolution(); }
  // By row and column, each cell once. A cell with hits is occupied only while its log-odds are positive.
  const Hits& hits() const { return hits_; }
  bool IsOccupied(grid::CellIndex cell) const { return log_odds_.ValueAt(cell) > 0; }
  // Known to be free, as far as the log-odds tell.
  bool IsFree(grid::CellIndex cell) const {
    const auto value = log_odds_.ValueAt(cell);
    return value != grid::LogOddsGrid::kUnknown && value < 0;
  }
  // Calls visit(cell, mean) for the occupied cells from column and row `low` to `high`, both included, row by row.
  template <typename Visit>
  void VisitOccupied(grid::CellIndex low, grid::CellIndex high, Visit&& visit) const {
    for (auto it = FirstFrom(hits_, {low.row, low.column}); it != hits_.end() && it->first.first <= high.row; ++it) {
      const grid::CellIndex cell{it->first.second, it->first.first};
      if (cell.column >= low.column && cell.column <= high.column && IsOccupied(cell)) visit(cell, it->second.mean);
    }
  }
  // The hit means of the occupied cells, m, row by row.
  std::vector<Eigen::Vector2d> OccupiedPoints() const;

  // Shrinks the grid to the known cells.
  void Crop() { log_odds_.Crop(); }
  // Rounds the hit means to a quarter of a millimetre, far below the accuracy of walls: more digits would not compress.
  void RoundMeans();

  // Bytes of memory held.
  std::size_t bytes() const;

  void Serialize(BinaryWriter& writer) const;
  static absl::StatusOr<SubmapGrid> Deserialize(BinaryReader& reader, const OccupancyOptions& options);

  friend bool operator==(const SubmapGrid& a, const SubmapGrid& b) {
    return a.log_odds_ == b.log_odds_ && a.hits_ == b.hits_;
  }

 private:
  // The first cell that is not before `key`.
  template <typename AnyHits>
  static auto FirstFrom(AnyHits& hits, const Key& key) {
    return std::lower_bound(hits.begin(), hits.end(), key,
                            [](const auto& hit, const Key& wanted) { return hit.first < wanted; });
  }

  explicit SubmapGrid(grid::LogOddsGrid grid) : log_odds_(std::move(grid)) {}

  std::vector<Key> AddHits(const std::vector<Eigen::Vector2d>& hits);

  grid::LogOddsGrid log_odds_;
  Hits hits_;
};

// The sensor model for LogOddsGrid. The simplified form (+1 for a hit, -1 for a crossing beam, clamped at 10) is the
// log-odds form with equal and opposite steps.
grid::LogOddsOptions LogOddsOptionsOf(const OccupancyOptions& options);

}  // namespace enfilade::slam
