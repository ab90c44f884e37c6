// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/likelihood_field.h"

#include <algorithm>
#include <cmath>

namespace enfilade::slam {
namespace {

constexpr int kBorder = 3;  // cells: the interpolation reads up to two cells beyond the point's
constexpr int kBlock = 64;  // cells: the array grows in multiples of this

int FloorToBlock(int v) { return static_cast<int>(std::floor(static_cast<double>(v) / kBlock)) * kBlock; }

// Cubic convolution (Keys 1981) with a = -1/2: the weights at `t` in [0, 1) of the samples at -1, 0, 1 and 2, and their
// derivatives.
void CubicWeights(double t, double* w, double* dw) {
  w[0] = t * (-0.5 + t * (1.0 - 0.5 * t));
  w[1] = 1.0 + t * t * (-2.5 + 1.5 * t);
  w[2] = t * (0.5 + t * (2.0 - 1.5 * t));
  w[3] = t * t * (-0.5 + 0.5 * t);
  dw[0] = -0.5 + t * (2.0 - 1.5 * t);
  dw[1] = t * (-5.0 + 4.5 * t);
  dw[2] = 0.5 + t * (4.0 - 4.5 * t);
  dw[3] = t * (-1.0 + 1.5 * t);
}

}  // namespace

LikelihoodField::LikelihoodField(double resolution, double reach)
    : resolution_(resolution), reach_(reach), reach_cells_(static_cast<int>(std::ceil(reach / resolution))) {}

grid::CellIndex LikelihoodField::CellOf(const Eigen::Vector2d& point) const {
  return {static_cast<int>(std::floor(point.x() / resolution_)), static_cast<int>(std::floor(point.y() / resolution_))};
}

void LikelihoodField::Add(const std::vector<Eigen::Vector2d>& points) {
  CellWindow bounds;
  for (const Eigen::Vector2d& p : points) bounds = Union(bounds, {CellOf(p), 1, 1});
  Cover(bounds);
  for (const Eigen::Vector2d& p : points) Stamp(p);
}

// Clears the surroundings of each changed cell, then stamps every point again that can reach into a cleared cell.
CellWindow LikelihoodField::Update(const SubmapGrid& grid, const std::vector<grid::CellIndex>& changed) {
  const int margin = reach_cells_ + 1;  // rounding may put a mean just outside its cell
  CellWindow bounds;
  for (const grid::CellIndex& cell : changed) bounds = Union(bounds, {cell, 1, 1});
  Cover(bounds);
  for (const grid::CellIndex& cell : changed) Clear(Dilated({cell, 1, 1}, margin));
  const CellWindow reaching = Dilated(bounds, 2 * margin);
  grid.VisitOccupied(reaching.min, {reaching.right() - 1, reaching.top() - 1},
                     [&](grid::CellIndex, const Eigen::Vector2d& mean) { Stamp(mean); });
  return Intersection(Dilated(bounds, margin), window_);
}

void LikelihoodField::Cover(const CellWindow& needed) {
  if (needed.empty()) return;
  const CellWindow all = Union(window_, Dilated(needed, reach_cells_ + kBorder));
  if (all == window_) return;
  const CellWindow grown = WindowBetween(FloorToBlock(all.min.column), FloorToBlock(all.min.row),
                                         FloorToBlock(all.right() + kBlock - 1), FloorToBlock(all.top() + kBlock - 1));
  std::vector<float> cells(grown.cell_count(), static_cast<float>(reach_ * reach_));
  for (int row = window_.min.row; row < window_.top(); ++row) {
    std::copy_n(cells_.begin() + static_cast<std::ptrdiff_t>(window_.index(window_.min.column, row)), window_.width,
                cells.begin() + static_cast<std::ptrdiff_t>(grown.index(window_.min.column, row)));
  }
  window_ = grown;
  cells_ = std::move(cells);
}

void LikelihoodField::Clear(const CellWindow& window) {
  const CellWindow w = Intersection(window, window_);
  for (int row = w.min.row; row < w.top(); ++row) {
    std::fill_n(cells_.begin() + static_cast<std::ptrdiff_t>(window_.index(w.min.column, row)), w.width,
                static_cast<float>(reach_ * reach_));
  }
}

void LikelihoodField::Stamp(const Eigen::Vector2d& point) {
  const grid::CellIndex cell = CellOf(point);
  const CellWindow w = Intersection(Dilated({cell, 1, 1}, reach_cells_), window_);
  const auto resolution = static_cast<float>(resolution_);
  const auto left = static_cast<float>((w.min.column + 0.5) * resolution_ - point.x());
  for (int row = w.min.row; row < w.top(); ++row) {
    const auto dy = static_cast<float>((row + 0.5) * resolution_ - point.y());
    float* const values = &cells_[window_.index(w.min.column, row)];
    for (int i = 0; i < w.width; ++i) {
      const float dx = left + resolution * static_cast<float>(i);
      values[i] = std::min(values[i], dx * dx + dy * dy);
    }
  }
}

LikelihoodField::Sample LikelihoodField::At(const Eigen::Vector2d& point) const {
  const double u = point.x() / resolution_ - 0.5;
  const double v = point.y() / resolution_ - 0.5;
  const double far = reach_ * reach_;
  if (!(std::abs(u) < 1e9) || !(std::abs(v) < 1e9)) return {far, Eigen::Vector2d::Zero()};
  const int column = static_cast<int>(std::floor(u));
  const int row = static_cast<int>(std::floor(v));
  if (column - 1 < window_.min.column || row - 1 < window_.min.row || column + 2 >= window_.right() ||
      row + 2 >= window_.top()) {
    return {far, Eigen::Vector2d::Zero()};
  }
  double wx[4], dx[4], wy[4], dy[4];
  CubicWeights(u - column, wx, dx);
  CubicWeights(v - row, wy, dy);
  double value = 0.0;
  double by_x = 0.0;
  double by_y = 0.0;
  for (int j = 0; j < 4; ++j) {
    const float* const q = &cells_[window_.index(column - 1, row - 1 + j)];
    const double along = wx[0] * q[0] + wx[1] * q[1] + wx[2] * q[2] + wx[3] * q[3];
    const double slope = dx[0] * q[0] + dx[1] * q[1] + dx[2] * q[2] + dx[3] * q[3];
    value += wy[j] * along;
    by_x += wy[j] * slope;
    by_y += dy[j] * along;
  }
  if (value <= 0.0) return {0.0, Eigen::Vector2d::Zero()};  // the interpolation undershoots between sharp corners
  return {value, Eigen::Vector2d(by_x, by_y) / resolution_};
}

}  // namespace enfilade::slam
