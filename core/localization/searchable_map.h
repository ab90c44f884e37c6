// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/grid/occupancy_grid.h"
#include "core/localization/bound_table.h"
#include "core/localization/localization_options.h"
#include "core/slam/matching/cell_window.h"
#include "core/slam/matching/likelihood_field.h"
#include "core/slam/matching/search_table.h"

namespace enfilade::localization {

// An occupancy grid, ready for robots to be located in it. Immutable.
class SearchableMap {
 public:
  // `grid` on the lattice of its resolution (grid::ResampleToLattice).
  SearchableMap(const grid::OccupancyGrid& grid, const LocalizationOptions& options);

  enum class Cell : std::uint8_t { kUnknown, kFree, kOccupied };
  Cell At(const Eigen::Vector2d& point) const;

  // The walls as a likelihood field, for refining and comparing.
  const slam::LikelihoodField& walls() const { return walls_; }
  // The same, coarser, for searching the whole map, and the surroundings of a pose.
  const BoundTable& bounds() const { return bounds_; }
  const slam::SearchTable& table() const { return table_; }
  // The cells of the table's lattice in which a robot may stand.
  const slam::CellWindow& ground() const { return ground_; }
  // Whether a robot may stand in one of the cells: ground that has been seen free, or ground beside it.
  bool HasGround(const slam::CellWindow& cells) const;
  // No wall or no ground is known: nothing can be located in it.
  bool empty() const { return empty_; }
  // Bytes of memory held.
  std::size_t bytes() const;

 private:
  void SumGround(double cell);

  double resolution_;
  slam::CellWindow window_;
  std::vector<Cell> cells_;
  slam::LikelihoodField walls_;
  BoundTable bounds_;
  slam::SearchTable table_;
  slam::CellWindow ground_;
  std::vector<std::int32_t> ground_sums_;  // of the cells below and to the left: (width + 1) x (height + 1)
  bool empty_ = true;
};

}  // namespace enfilade::localization
