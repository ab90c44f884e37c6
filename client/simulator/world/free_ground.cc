// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/world/free_ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace enfilade::simulator {
namespace {

constexpr double kStopsRobot = 0.5;  // m: faces that begin lower
constexpr double kSample = 0.05;     // m, along faces and lines
constexpr double kNarrowCost = 3.0;  // how much longer a way beside a wall counts
constexpr double kSnap = 0.3;        // m, from an end of a way to free ground

}  // namespace

FreeGround::FreeGround(const LevelWorld& level, double clearance) : clearance_(clearance), lower_(level.lower()) {
  const Eigen::Vector2d size = level.upper() - lower_;
  width_ = static_cast<int>(std::ceil(size.x() / kCell)) + 1;
  height_ = static_cast<int>(std::ceil(size.y() / kCell)) + 1;
  distance_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), static_cast<float>(kFarthest));
  const int reach = static_cast<int>(std::ceil(kFarthest / kCell));
  for (const Face& face : level.faces()) {
    if (face.bottom >= kStopsRobot || face.gate >= 0) continue;
    const int samples = 1 + static_cast<int>((face.b - face.a).norm() / kSample);
    for (int i = 0; i <= samples; ++i) {
      const Eigen::Vector2d point = face.a + (face.b - face.a) * (static_cast<double>(i) / samples);
      const int column = static_cast<int>(std::floor((point.x() - lower_.x()) / kCell));
      const int row = static_cast<int>(std::floor((point.y() - lower_.y()) / kCell));
      for (int r = std::max(0, row - reach); r <= std::min(height_ - 1, row + reach); ++r) {
        for (int c = std::max(0, column - reach); c <= std::min(width_ - 1, column + reach); ++c) {
          const int cell = r * width_ + c;
          float& distance = distance_[static_cast<std::size_t>(cell)];
          distance = std::min(distance, static_cast<float>((MiddleOf(cell) - point).norm()));
        }
      }
    }
  }
}

int FreeGround::CellOf(const Eigen::Vector2d& point) const {
  const int column = static_cast<int>(std::floor((point.x() - lower_.x()) / kCell));
  const int row = static_cast<int>(std::floor((point.y() - lower_.y()) / kCell));
  return column < 0 || row < 0 || column >= width_ || row >= height_ ? -1 : row * width_ + column;
}

Eigen::Vector2d FreeGround::MiddleOf(int cell) const {
  const int row = cell / width_;
  return lower_ + kCell * Eigen::Vector2d(cell % width_ + 0.5, row + 0.5);
}

double FreeGround::DistanceAt(const Eigen::Vector2d& point) const {
  const int cell = CellOf(point);
  return cell < 0 ? 0.0 : distance_[static_cast<std::size_t>(cell)];
}

double FreeGround::LineDistance(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const {
  const int samples = 1 + static_cast<int>((b - a).norm() / kSample);
  double least = kFarthest;
  for (int i = 0; i <= samples; ++i) {
    least = std::min(least, DistanceAt(a + (b - a) * (static_cast<double>(i) / samples)));
  }
  return least;
}

int FreeGround::NearestFree(const Eigen::Vector2d& point) const {
  int nearest = -1;
  double least = kSnap;
  for (double dx = -kSnap; dx <= kSnap; dx += kCell) {
    for (double dy = -kSnap; dy <= kSnap; dy += kCell) {
      const int cell = CellOf(point + Eigen::Vector2d(dx, dy));
      if (cell < 0 || distance_[static_cast<std::size_t>(cell)] < clearance_) continue;
      const double off = (MiddleOf(cell) - point).norm();
      if (off > least) continue;
      least = off;
      nearest = cell;
    }
  }
  return nearest;
}

// A* (Hart, Nilsson, Raphael 1968) over eight neighbours.
std::vector<int> FreeGround::Search(int from, int to, const Box& box) const {
  std::vector<float> cost(distance_.size(), std::numeric_limits<float>::infinity());
  std::vector<int> before(distance_.size(), -1);
  using Entry = std::pair<double, int>;  // estimated length of the way through the cell
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const Eigen::Vector2d goal = MiddleOf(to);
  cost[static_cast<std::size_t>(from)] = 0.0F;
  open.emplace(0.0, from);
  while (!open.empty()) {
    const int cell = open.top().second;
    const double estimate = open.top().first;
    open.pop();
    if (cell == to) break;
    const double here = cost[static_cast<std::size_t>(cell)];
    if (estimate > here + (goal - MiddleOf(cell)).norm() + 1e-3) continue;  // reached by a shorter way meanwhile
    for (int dr = -1; dr <= 1; ++dr) {
      for (int dc = -1; dc <= 1; ++dc) {
        const int column = cell % width_ + dc;
        const int row = cell / width_ + dr;
        if ((dr == 0 && dc == 0) || column < 0 || row < 0 || column >= width_ || row >= height_) continue;
        const int next = row * width_ + column;
        const double free = distance_[static_cast<std::size_t>(next)];
        const Eigen::Vector2d at = MiddleOf(next);
        if (free < clearance_ || (at.array() < box.lower.array()).any() || (at.array() > box.upper.array()).any()) {
          continue;
        }
        const double way = kCell * std::hypot(dr, dc) * (1.0 + kNarrowCost * (kFarthest - free) / kFarthest);
        const auto total = static_cast<float>(here + way);
        if (total >= cost[static_cast<std::size_t>(next)]) continue;
        cost[static_cast<std::size_t>(next)] = total;
        before[static_cast<std::size_t>(next)] = cell;
        open.emplace(total + (goal - at).norm(), next);
      }
    }
  }
  std::vector<int> cells;
  if (from != to && before[static_cast<std::size_t>(to)] < 0) return cells;
  for (int cell = to; cell >= 0; cell = before[static_cast<std::size_t>(cell)]) cells.push_back(cell);
  std::reverse(cells.begin(), cells.end());
  return cells;
}

// Leaves points out as long as the straight line keeps the distance to walls that the way itself keeps.
std::vector<Eigen::Vector2d> FreeGround::Straighten(const std::vector<Eigen::Vector2d>& points) const {
  constexpr double kComfortable = 0.4;  // m
  std::vector<Eigen::Vector2d> corners;
  for (std::size_t i = 0; i + 1 < points.size();) {
    std::size_t farthest = i + 1;
    double least = std::min(kComfortable, DistanceAt(points[i]));
    for (std::size_t k = i + 1; k < points.size(); ++k) {
      least = std::min(least, DistanceAt(points[k]));
      if (LineDistance(points[i], points[k]) >= least - 0.02) farthest = k;
    }
    corners.push_back(points[farthest]);
    i = farthest;
  }
  return corners;
}

std::vector<Eigen::Vector2d> FreeGround::Way(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                             const std::optional<Box>& box) const {
  const int begin = NearestFree(from);
  const int end = NearestFree(to);
  if (begin < 0 || end < 0) return {};
  const Box everywhere{lower_, lower_ + kCell * Eigen::Vector2d(width_, height_)};
  std::vector<Eigen::Vector2d> points;
  for (const int cell : Search(begin, end, box.value_or(everywhere))) points.push_back(MiddleOf(cell));
  if (points.empty()) return {};
  points.front() = from;
  points.back() = to;
  if (points.size() == 1) return points;
  return Straighten(points);
}

}  // namespace enfilade::simulator
