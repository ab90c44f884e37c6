// SPDX-License-Identifier: Apache-2.0
#include "core/graph/point_index.h"

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <cmath>
#include <iterator>
#include <utility>

namespace enfilade::graph {
namespace {

namespace bg = boost::geometry;
namespace bgi = boost::geometry::index;

using BoostPoint = bg::model::point<double, 2, bg::cs::cartesian>;
using Box = bg::model::box<BoostPoint>;
using Polygon = bg::model::polygon<BoostPoint>;
using Value = std::pair<BoostPoint, int>;
constexpr std::size_t kNodeSize = 16;
using Tree = bgi::rtree<Value, bgi::rstar<kNodeSize>>;

// Searches look at each changed point, so they are packed once they are more than this, or than this share of all.
constexpr std::size_t kMaxChanged = 64;
constexpr std::size_t kMaxChangedShare = 64;
constexpr double kGrowth = 2.0;
constexpr double kSmallest = 1e-3;  // so that a search among points at one place grows, too

double DistanceTo(const Eigen::Vector2d& center, double x, double y) {
  return std::hypot(x - center.x(), y - center.y());
}

bool IsNearer(const PointIndex::Neighbour& a, const PointIndex::Neighbour& b) {
  return a.distance != b.distance ? a.distance < b.distance : a.number < b.number;
}

Polygon ToPolygon(const std::vector<Eigen::Vector2d>& corners) {
  Polygon polygon;
  for (const Eigen::Vector2d& corner : corners) bg::append(polygon.outer(), BoostPoint(corner.x(), corner.y()));
  bg::correct(polygon);
  return polygon;
}

}  // namespace

struct PointIndex::Packed {
  Tree tree;

  // No point is farther away.
  double FarthestFrom(const Eigen::Vector2d& center) const {
    if (tree.empty()) return 0.0;
    const Box box = tree.bounds();
    return std::hypot(
        std::max(std::abs(box.min_corner().get<0>() - center.x()), std::abs(box.max_corner().get<0>() - center.x())),
        std::max(std::abs(box.min_corner().get<1>() - center.y()), std::abs(box.max_corner().get<1>() - center.y())));
  }

  // Of a circle with the area that `count` points have on average.
  double RadiusOf(int count) const {
    if (tree.empty()) return 0.0;
    const Box box = tree.bounds();
    const double side = std::max({box.max_corner().get<0>() - box.min_corner().get<0>(),
                                  box.max_corner().get<1>() - box.min_corner().get<1>(), kSmallest});
    return side * std::sqrt(static_cast<double>(count) / static_cast<double>(tree.size()));
  }

  void FindWithin(const Eigen::Vector2d& center, double radius, const Filter& accept,
                  std::vector<Neighbour>& found) const {
    const Box box(BoostPoint(center.x() - radius, center.y() - radius),
                  BoostPoint(center.x() + radius, center.y() + radius));
    for (auto it = tree.qbegin(bgi::intersects(box)); it != tree.qend(); ++it) {
      const double distance = DistanceTo(center, it->first.get<0>(), it->first.get<1>());
      if (distance <= radius && accept(it->second)) found.push_back({it->second, distance});
    }
  }
};

PointIndex::PointIndex() : packed_(std::make_shared<const Packed>()) {}

PointIndex PointIndex::With(const std::vector<Point>& changes) const {
  PointIndex next = *this;
  for (const Point& change : changes) next.changed_[change.number] = change.position;
  const std::size_t limit = std::max(kMaxChanged, packed_->tree.size() / kMaxChangedShare);
  if (next.changed_.size() > limit) next.Pack();
  return next;
}

void PointIndex::Pack() {
  std::vector<Value> values;
  values.reserve(packed_->tree.size() + changed_.size());
  for (const Value& value : packed_->tree) {
    if (IsCurrent(value.second)) values.push_back(value);
  }
  for (const auto& [number, position] : changed_) {
    if (position) values.emplace_back(BoostPoint(position->x(), position->y()), number);
  }
  packed_ = std::make_shared<const Packed>(Packed{Tree(values)});
  changed_.clear();
}

// Looks in growing circles, from one that holds `limit` points where they lie as densely as on average. (The
// incremental nearest-neighbour query of Boost 1.74 takes seconds near the border of 100,000 points.)
std::vector<PointIndex::Neighbour> PointIndex::FindNearest(const Eigen::Vector2d& center, double radius, int limit,
                                                           const Filter& accept) const {
  std::vector<Neighbour> found;
  if (limit <= 0 || std::isnan(radius)) return found;
  const auto count = static_cast<std::size_t>(limit);
  const double farthest = std::min(radius, packed_->FarthestFrom(center));
  double reach = std::min(farthest, packed_->RadiusOf(limit));
  packed_->FindWithin(
      center, reach, [&](int number) { return IsCurrent(number) && accept(number); }, found);
  while (found.size() < count && reach < farthest) {
    reach = std::min(farthest, kGrowth * reach);
    found.clear();
    packed_->FindWithin(
        center, reach, [&](int number) { return IsCurrent(number) && accept(number); }, found);
  }
  for (const auto& [number, position] : changed_) {
    if (!position) continue;
    const double distance = DistanceTo(center, position->x(), position->y());
    if (distance <= radius && accept(number)) found.push_back({number, distance});
  }
  std::sort(found.begin(), found.end(), IsNearer);
  if (found.size() > count) found.resize(count);
  return found;
}

std::vector<int> PointIndex::FindInPolygon(const std::vector<Eigen::Vector2d>& corners, const Filter& accept) const {
  std::vector<int> found;
  const Polygon polygon = ToPolygon(corners);
  const Box box = bg::return_envelope<Box>(polygon);
  const auto add = [&](const BoostPoint& point, int number) {
    if (bg::covered_by(point, polygon) && accept(number)) found.push_back(number);
  };
  for (auto it = packed_->tree.qbegin(bgi::intersects(box)); it != packed_->tree.qend(); ++it) {
    if (IsCurrent(it->second)) add(it->first, it->second);
  }
  for (const auto& [number, position] : changed_) {
    if (position) add(BoostPoint(position->x(), position->y()), number);
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace enfilade::graph
