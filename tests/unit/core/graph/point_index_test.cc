// SPDX-License-Identifier: Apache-2.0
#include "core/graph/point_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <vector>

namespace enfilade::graph {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::IsEmpty;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Points = std::map<int, Eigen::Vector2d>;

bool All(int) { return true; }

std::vector<int> NumbersOf(const std::vector<PointIndex::Neighbour>& neighbours) {
  std::vector<int> numbers;
  for (const PointIndex::Neighbour& neighbour : neighbours) numbers.push_back(neighbour.number);
  return numbers;
}

std::vector<int> NearestOf(const Points& points, const Eigen::Vector2d& center, double radius, int limit,
                           const PointIndex::Filter& accept) {
  std::vector<std::pair<double, int>> found;
  for (const auto& [number, point] : points) {
    const double distance = std::hypot(point.x() - center.x(), point.y() - center.y());
    if (distance <= radius && accept(number)) found.emplace_back(distance, number);
  }
  std::sort(found.begin(), found.end());
  std::vector<int> numbers;
  for (const auto& [distance, number] : found) {
    if (static_cast<int>(numbers.size()) < limit) numbers.push_back(number);
  }
  return numbers;
}

// On a coarse grid, so that distances are often equal.
Eigen::Vector2d RandomPoint(std::mt19937& random) {
  return {static_cast<double>(random() % 40), static_cast<double>(random() % 40)};
}

// Random changes of versions, each made from an earlier one; every version answers as a list of its points would.
TEST(PointIndex, EveryVersionAnswersAsAListDoes) {
  std::mt19937 random(7);
  std::vector<PointIndex> versions(1);
  std::vector<Points> expected(1);
  for (int step = 0; step < 60; ++step) {
    const std::size_t from = random() % versions.size();
    Points points = expected[from];
    std::vector<PointIndex::Point> changes;
    for (std::uint32_t n = random() % (step % 5 == 0 ? 300 : 20); n > 0; --n) {
      const int number = static_cast<int>(random() % 500);
      if (random() % 4 == 0) {
        points.erase(number);
        changes.push_back({.number = number});
      } else {
        points[number] = RandomPoint(random);
        changes.push_back({number, points[number]});
      }
    }
    versions.push_back(versions[from].With(changes));
    expected.push_back(std::move(points));
    for (std::size_t v = 0; v < versions.size(); ++v) {
      const Eigen::Vector2d center = RandomPoint(random);
      const double radius = random() % 3 == 0 ? kInfinity : static_cast<double>(random() % 15);
      const int limit = 1 + static_cast<int>(random() % 40);
      const PointIndex::Filter odd = [](int number) { return number % 2 == 1; };
      const PointIndex::Filter accept = random() % 2 == 0 ? PointIndex::Filter(All) : odd;
      ASSERT_THAT(NumbersOf(versions[v].FindNearest(center, radius, limit, accept)),
                  ElementsAreArray(NearestOf(expected[v], center, radius, limit, accept)))
          << "version " << v << " after step " << step;
      // An axis-aligned rectangle, of which a list knows the answer.
      const Eigen::Vector2d other = RandomPoint(random);
      const Eigen::Vector2d low = center.cwiseMin(other);
      const Eigen::Vector2d high = center.cwiseMax(other) + Eigen::Vector2d(0.5, 0.5);
      std::vector<int> inside;
      for (const auto& [number, point] : expected[v]) {
        const bool is_in = (point.array() >= low.array()).all() && (point.array() <= high.array()).all();
        if (is_in && accept(number)) inside.push_back(number);
      }
      std::vector<Eigen::Vector2d> corners = {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
      if (random() % 2 == 0) std::reverse(corners.begin(), corners.end());
      ASSERT_THAT(versions[v].FindInPolygon(corners, accept), ElementsAreArray(inside)) << "version " << v;
    }
  }
}

TEST(PointIndex, IncludesTheEdgeOfACircle) {
  const PointIndex index = PointIndex().With({{1, Eigen::Vector2d(3, 4)}, {2, Eigen::Vector2d(3, 4.001)}});
  EXPECT_THAT(NumbersOf(index.FindNearest({0, 0}, 5.0, 10, All)), ElementsAre(1));
  EXPECT_DOUBLE_EQ(index.FindNearest({0, 0}, 5.0, 10, All).front().distance, 5.0);
  EXPECT_THAT(index.FindNearest({0, 0}, 4.999, 10, All), IsEmpty());
}

TEST(PointIndex, FollowsTheOutlineOfAPolygon) {
  // An L: the point between its arms is outside.
  const std::vector<Eigen::Vector2d> corners = {{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 4}, {0, 4}};
  const PointIndex index = PointIndex().With({{1, Eigen::Vector2d(3, 0.5)},
                                              {2, Eigen::Vector2d(3, 3)},
                                              {3, Eigen::Vector2d(0.5, 3)},
                                              {4, Eigen::Vector2d(1, 2)}});
  EXPECT_THAT(index.FindInPolygon(corners, All), ElementsAre(1, 3, 4)) << "4 lies on the edge";
}

TEST(PointIndex, AnEmptyOneFindsNothing) {
  EXPECT_THAT(PointIndex().FindNearest({0, 0}, kInfinity, 10, All), IsEmpty());
  EXPECT_THAT(PointIndex().FindInPolygon({{0, 0}, {1, 0}, {0, 1}}, All), IsEmpty());
}

}  // namespace
}  // namespace enfilade::graph
