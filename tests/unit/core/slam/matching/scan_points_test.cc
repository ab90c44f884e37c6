// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/scan_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace enfilade::slam {
namespace {

std::vector<Eigen::Vector2d> RandomWalk(std::size_t count, double step, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, step);
  std::vector<Eigen::Vector2d> points;
  Eigen::Vector2d p(0.0, 0.0);
  for (std::size_t i = 0; i < count; ++i) points.push_back(p += Eigen::Vector2d(normal(random), normal(random)));
  return points;
}

bool IsSubsequence(const std::vector<Eigen::Vector2d>& part, const std::vector<Eigen::Vector2d>& whole) {
  auto at = whole.begin();
  return std::all_of(part.begin(), part.end(), [&](const Eigen::Vector2d& p) {
    at = std::find(at, whole.end(), p);
    return at != whole.end();
  });
}

TEST(Thinned, KeepsAPointAsSoonAsItIsFarEnoughFromTheLastKept) {
  const std::vector<Eigen::Vector2d> line{{0.0, 0.0}, {0.3, 0.0}, {0.6, 0.0}, {0.5, 0.0}, {1.25, 0.0}};
  const std::vector<Eigen::Vector2d> expected{{0.0, 0.0}, {0.6, 0.0}, {1.25, 0.0}};
  EXPECT_EQ(Thinned(line, 0.5), expected);
}

TEST(Thinned, LeavesNoTwoConsecutivePointsNearAndDropsNoneThatIsFar) {
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    const auto points = RandomWalk(300, 0.04, seed);
    const auto kept = Thinned(points, 0.05);
    EXPECT_TRUE(IsSubsequence(kept, points));
    for (std::size_t i = 1; i < kept.size(); ++i) EXPECT_GE((kept[i] - kept[i - 1]).norm(), 0.05 - 1e-12);
    std::size_t last = 0;  // of the kept
    for (const Eigen::Vector2d& p : points) {
      if (last + 1 < kept.size() && p == kept[last + 1]) ++last;
      EXPECT_TRUE(p == kept[last] || (p - kept[last]).norm() < 0.05);
    }
  }
}

TEST(Thinned, WithoutSpacingKeepsAll) {
  const auto points = RandomWalk(20, 0.1, 3);
  EXPECT_EQ(Thinned(points, 0.0), points);
  EXPECT_TRUE(Thinned({}, 0.05).empty());
}

TEST(Subsampled, IsEvenlySpacedAndNeverLongerThanAsked) {
  for (const std::size_t size : {0UL, 1UL, 9UL, 10UL, 11UL, 19UL, 100UL, 101UL, 1'081UL}) {
    const auto points = RandomWalk(size, 0.1, 4);
    const auto kept = Subsampled(points, 10);
    EXPECT_LE(kept.size(), 10U) << size;
    EXPECT_TRUE(IsSubsequence(kept, points));
    EXPECT_TRUE(size > 10 || kept == points);
    EXPECT_TRUE(size <= 10 || kept.size() > 5) << size << ": no more are dropped than the even spacing needs";
    const std::size_t step = (size + 9) / 10;
    for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept[i], points[i * std::max<std::size_t>(step, 1)]);
  }
}

TEST(SurfaceNormals, StandOnStraightSurfacesAndAreUnknownElsewhere) {
  constexpr double kTurn = 0.4;  // rad
  const Eigen::Vector2d along(std::cos(kTurn), std::sin(kTurn));
  const Eigen::Vector2d across(-along.y(), along.x());
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 20; ++i) points.push_back(0.06 * i * along + (i % 2 == 0 ? 0.008 : -0.008) * across);
  points.push_back(20.0 * across);  // alone
  const std::size_t of_post = points.size();
  for (int i = 0; i < 6; ++i) {  // round a post
    points.push_back(9.0 * across + 0.1 * Eigen::Vector2d(std::cos(0.6 * i), std::sin(0.6 * i)));
  }
  const std::vector<Eigen::Vector2d> normals = SurfaceNormals(points);
  ASSERT_EQ(normals.size(), points.size());
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_NEAR(normals[i].norm(), 1.0, 1e-9);
    EXPECT_GT(std::abs(normals[i].dot(across)), std::cos(0.1)) << i;
  }
  EXPECT_TRUE(normals[of_post - 1].isZero());
  for (std::size_t i = of_post; i < points.size(); ++i) EXPECT_TRUE(normals[i].isZero()) << i;
  EXPECT_TRUE(SurfaceNormals({}).empty());
  EXPECT_TRUE(SurfaceNormals({{1, 0}, {1, 0.06}})[0].isZero()) << "two points are no surface";
}

}  // namespace
}  // namespace enfilade::slam
