// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace enfilade::prior {

// Finds segments near a place: a hash of square cells, with the segments that pass each of them or a neighbour of it.
class SegmentGrid {
 public:
  explicit SegmentGrid(double cell) : cell_(cell) {}

  void Add(int id, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    ForEachCell(a, b, [&](std::uint64_t key) {
      std::vector<int>& ids = cells_[key];
      if (ids.empty() || ids.back() != id) ids.push_back(id);
    });
  }

  // All segments within a cell's side of the segment from a to b, each at least once.
  template <typename Visit>
  void ForEachNear(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Visit& visit) const {
    const double length = (b - a).norm();
    const int steps = 1 + static_cast<int>(length / cell_);
    std::uint64_t last = 0;
    for (int i = 0; i <= steps; ++i) {
      const Eigen::Vector2d p = a + (b - a) * (static_cast<double>(i) / steps);
      const std::uint64_t key = Key(Index(p.x()), Index(p.y()));
      if (i > 0 && key == last) continue;
      last = key;
      const auto found = cells_.find(key);
      if (found == cells_.end()) continue;
      for (const int id : found->second) visit(id);
    }
  }

  // About how many segments are visited if ForEachNear is called along each of them.
  double CountPairs() const {
    double pairs = 0;
    for (const auto& [key, ids] : cells_) {
      const auto count = static_cast<double>(ids.size());
      pairs += count * count / kNeighbours;
    }
    return pairs;
  }

 private:
  static constexpr double kNeighbours = 9;  // cells in which a segment of one cell is listed

  std::int64_t Index(double value) const {
    constexpr double kLargest = 1e18;  // of a 64 bit integer
    return static_cast<std::int64_t>(std::clamp(std::floor(value / cell_), -kLargest, kLargest));
  }
  static std::uint64_t Key(std::int64_t x, std::int64_t y) {
    return static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ULL ^ static_cast<std::uint64_t>(y);
  }
  // The cells along the segment with their eight neighbours.
  template <typename Use>
  void ForEachCell(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Use& use) const {
    const int steps = 1 + static_cast<int>((b - a).norm() / cell_);
    for (int i = 0; i <= steps; ++i) {
      const Eigen::Vector2d p = a + (b - a) * (static_cast<double>(i) / steps);
      for (std::int64_t y = Index(p.y()) - 1; y <= Index(p.y()) + 1; ++y) {
        for (std::int64_t x = Index(p.x()) - 1; x <= Index(p.x()) + 1; ++x) use(Key(x, y));
      }
    }
  }

  double cell_;
  std::unordered_map<std::uint64_t, std::vector<int>> cells_;
};

}  // namespace enfilade::prior
