// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

namespace enfilade::graph {

// Numbered points in the plane, in any unit. Immutable, and cheap to copy and to change a little: versions share a
// packed R-tree (Guttman 1984; packed by sort-tile-recursion, Leutenegger et al. 1997), beside which each has the
// points that have changed since. Readers of one version never wait for the next one. Thread-safe.
class PointIndex {
 public:
  struct Point {
    int number = 0;
    std::optional<Eigen::Vector2d> position = std::nullopt;  // finite; unset: there is none of this number
  };
  struct Neighbour {
    int number = 0;
    double distance = 0.0;
  };
  // Whether a point takes part in a search.
  using Filter = std::function<bool(int number)>;

  PointIndex();

  // The next version: each of `changes` replaces the point of its number, the last one if there are several. Takes time
  // proportional to the changes and, now and then, to n log n.
  PointIndex With(const std::vector<Point>& changes) const;

  // At most `limit` points within `radius` (infinity: at any distance), its edge included; the nearest first, of the
  // same distance the lower number.
  std::vector<Neighbour> FindNearest(const Eigen::Vector2d& center, double radius, int limit,
                                     const Filter& accept) const;
  // The points in a simple polygon, its edge included, by number. At least three corners, in either direction.
  std::vector<int> FindInPolygon(const std::vector<Eigen::Vector2d>& corners, const Filter& accept) const;

 private:
  struct Packed;

  bool IsCurrent(int number) const { return !changed_.contains(number); }
  void Pack();

  std::shared_ptr<const Packed> packed_;
  std::unordered_map<int, std::optional<Eigen::Vector2d>> changed_;  // these numbers of `packed_` count no more
};

}  // namespace enfilade::graph
