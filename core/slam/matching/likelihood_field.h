// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/slam/matching/cell_window.h"
#include "core/slam/submaps/submap_grid.h"

namespace enfilade::slam {

// The likelihood field of a set of wall points (Thrun, Burgard, Fox, "Probabilistic Robotics", 2005, section 6.4), kept
// as squared distance to the nearest point: minus twice the log-likelihood times sigma^2. It is stored at cells'
// centres, truncated at `reach`, and interpolated by bicubic convolution (Keys 1981), which is exact where the field
// is a quadratic, as the squared distance to a straight wall is: the field knows walls to a fraction of a cell.
class LikelihoodField {
 public:
  struct Sample {
    double squared_distance = 0.0;                       // m^2, at most reach^2
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();  // of it, m
  };

  // `resolution` and `reach` in m.
  LikelihoodField(double resolution, double reach);

  // Adds points; each only ever lowers the field.
  void Add(const std::vector<Eigen::Vector2d>& points);

  // Makes the field that of `grid`'s occupied points again after `changed` (not empty) changed. Returns the cells in
  // which the field may have changed.
  CellWindow Update(const SubmapGrid& grid, const std::vector<grid::CellIndex>& changed);

  Sample At(const Eigen::Vector2d& point) const;

  double resolution() const { return resolution_; }
  double reach() const { return reach_; }
  const CellWindow& window() const { return window_; }
  // Bytes of memory held.
  std::size_t bytes() const { return cells_.capacity() * sizeof(float); }
  // Row-major over window().
  const std::vector<float>& squared_distances() const { return cells_; }

 private:
  void Cover(const CellWindow& needed);
  void Clear(const CellWindow& window);
  void Stamp(const Eigen::Vector2d& point);
  grid::CellIndex CellOf(const Eigen::Vector2d& point) const;

  double resolution_;
  double reach_;
  int reach_cells_;
  CellWindow window_;
  std::vector<float> cells_;
};

}  // namespace enfilade::slam
