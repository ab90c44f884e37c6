// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/slam/matching/cell_window.h"
#include "core/slam/submaps/submap_grid.h"

namespace enfilade::slam {

// The likelihood field of a set of wall points (Thrun, Burgard, Fox, "Probabilistic Robotics", 2005, section 6.4), kept
// as the squared distance d^2 to the nearest point: d^2 = -2 sigma^2 log(likelihood). It is stored at cell centres,
// truncated at `reach`^2, and interpolated by bicubic convolution (Keys 1981). This interpolation is exact for
// quadratics, such as the squared distance to a straight wall, so the field locates walls to a fraction of a cell.
class LikelihoodField {
 public:
  struct Sample {
    double squared_distance = 0.0;                       // m^2, at most reach^2
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();  // m
  };

  // `resolution` and `reach` in m.
  LikelihoodField(double resolution, double reach);

  // Adds points: the field becomes the minimum of itself and theirs.
  void Add(const std::vector<Eigen::Vector2d>& points);

  // Brings the field up to date with the occupied points of `grid` after the cells `changed` (not empty) have changed.
  // Returns the window in which the field may have changed.
  CellWindow Update(const SubmapGrid& grid, const std::vector<grid::CellIndex>& changed);

  Sample At(const Eigen::Vector2d& point) const;

  double resolution() const { return resolution_; }
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
