// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/floor_areas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>

namespace enfilade::simulator {
namespace {

constexpr double kCell = 0.1;    // m
constexpr double kMargin = 1.0;  // m around the barriers
constexpr int kBarrier = -1;
constexpr int kUnseen = 0;

class FloorGrid {
 public:
  explicit FloorGrid(const std::vector<Barrier>& barriers) {
    Eigen::Vector2d upper = barriers[0].first;
    lower_ = upper;
    for (const auto& [a, b] : barriers) {
      lower_ = lower_.cwiseMin(a).cwiseMin(b);
      upper = upper.cwiseMax(a).cwiseMax(b);
    }
    lower_.array() -= kMargin;
    width_ = static_cast<int>((upper.x() + kMargin - lower_.x()) / kCell) + 1;
    height_ = static_cast<int>((upper.y() + kMargin - lower_.y()) / kCell) + 1;
    cells_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), kUnseen);
    for (const auto& [a, b] : barriers) {
      const int samples = 1 + static_cast<int>((b - a).norm() / (kCell / 4.0));
      for (int i = 0; i <= samples; ++i) {
        const Eigen::Vector2d at = (a + (b - a) * (static_cast<double>(i) / samples) - lower_) / kCell;
        cells_[IndexOf(static_cast<int>(at.x()), static_cast<int>(at.y()))] = kBarrier;
      }
    }
  }

  std::vector<FloorArea> Divide(double least) {
    MeasureDistances();
    std::vector<FloorArea> areas;
    Fill(0, 1);  // outside
    int label = 1;
    for (int cell = 0; cell < width_ * height_; ++cell) {
      if (At(cell) != kUnseen) continue;
      const std::vector<int> piece = Fill(cell, ++label);
      const double size = static_cast<double>(piece.size()) * kCell * kCell;
      if (size < least) continue;
      const int inside = *std::max_element(piece.begin(), piece.end(), [&](int a, int b) {
        return distance_[static_cast<std::size_t>(a)] < distance_[static_cast<std::size_t>(b)];
      });
      areas.push_back({Outline(cell, label), size, Corner(inside % width_, inside / width_).array() + kCell / 2.0});
    }
    std::stable_sort(areas.begin(), areas.end(),
                     [](const FloorArea& a, const FloorArea& b) { return a.size > b.size; });
    return areas;
  }

 private:
  static constexpr std::array<std::pair<int, int>, 4> kNeighbours = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

  std::size_t IndexOf(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column);
  }
  int At(int cell) const { return cells_[static_cast<std::size_t>(cell)]; }
  bool Is(int column, int row, int label) const {
    return column >= 0 && row >= 0 && column < width_ && row < height_ && At(row * width_ + column) == label;
  }
  Eigen::Vector2d Corner(int column, int row) const { return lower_ + kCell * Eigen::Vector2d(column, row); }

  // In steps between neighbours, from the barriers.
  void MeasureDistances() {
    distance_.assign(cells_.size(), -1);
    std::deque<int> open;
    for (int cell = 0; cell < width_ * height_; ++cell) {
      if (At(cell) != kBarrier) continue;
      distance_[static_cast<std::size_t>(cell)] = 0;
      open.push_back(cell);
    }
    for (; !open.empty(); open.pop_front()) {
      for (const auto& [dc, dr] : kNeighbours) {
        const int column = open.front() % width_ + dc;
        const int row = open.front() / width_ + dr;
        if (column < 0 || row < 0 || column >= width_ || row >= height_) continue;
        int& distance = distance_[IndexOf(column, row)];
        if (distance >= 0) continue;
        distance = distance_[static_cast<std::size_t>(open.front())] + 1;
        open.push_back(row * width_ + column);
      }
    }
  }

  std::vector<int> Fill(int start, int label) {
    std::vector<int> piece = {start};
    cells_[static_cast<std::size_t>(start)] = label;
    for (std::size_t i = 0; i < piece.size(); ++i) {
      for (const auto& [dc, dr] : kNeighbours) {
        const int column = piece[i] % width_ + dc;
        const int row = piece[i] / width_ + dr;
        if (!Is(column, row, kUnseen)) continue;
        cells_[IndexOf(column, row)] = label;
        piece.push_back(row * width_ + column);
      }
    }
    return piece;
  }

  // Walks around the piece, which is on the left. `first`: its first cell in the order of rows, whose lower side is
  // outside.
  std::vector<Eigen::Vector2d> Outline(int first, int label) const {
    std::vector<Eigen::Vector2d> outline;
    const int begin_column = first % width_;
    const int begin_row = first / width_;
    int column = begin_column;  // a corner of cells
    int row = begin_row;
    int heading = 0;  // index into kNeighbours
    do {
      const auto& [dc, dr] = kNeighbours[static_cast<std::size_t>(heading)];
      column += dc;
      row += dr;
      // The cells ahead, to the left and to the right of the heading.
      const int left_column = column + (dc - dr - 1) / 2;
      const int left_row = row + (dr + dc - 1) / 2;
      const int right_column = column + (dc + dr - 1) / 2;
      const int right_row = row + (dr - dc - 1) / 2;
      int turned = heading;
      if (!Is(left_column, left_row, label)) {
        turned = (heading + 1) % 4;
      } else if (Is(right_column, right_row, label)) {
        turned = (heading + 3) % 4;
      }
      if (turned != heading) outline.push_back(Corner(column, row));
      heading = turned;
    } while (column != begin_column || row != begin_row || heading != 0);
    return outline;
  }

  Eigen::Vector2d lower_;
  int width_ = 0;
  int height_ = 0;
  std::vector<int> cells_;     // kBarrier, kUnseen, or the piece
  std::vector<int> distance_;  // cells
};

}  // namespace

std::vector<FloorArea> DivideFloor(const std::vector<Barrier>& barriers, double least) {
  if (barriers.empty()) return {};
  return FloorGrid(barriers).Divide(least);
}

}  // namespace enfilade::simulator
