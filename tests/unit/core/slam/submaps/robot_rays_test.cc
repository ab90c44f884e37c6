// SPDX-License-Identifier: Apache-2.0
#include "core/slam/submaps/robot_rays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace enfilade::slam {
namespace {

sensor::LaserScan RandomScan(int beams, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> range(0.5F, 20.0F);
  sensor::LaserScan scan;
  scan.angle_min = -2.0;
  scan.angle_increment = 4.0 / beams;
  scan.range_max = 25.0F;
  scan.T_robot_laser = {0.12, -0.05, 0.3};
  for (int i = 0; i < beams; ++i) scan.ranges.push_back(range(random));
  return scan;
}

bool IsSinglePrecision(const Eigen::Vector2d& p) { return p == p.cast<float>().cast<double>(); }

// Odd numbers, too: the compiler handles points in pairs.
TEST(RobotRays, HaveSinglePrecisionWithinAMicrometre) {
  for (int beams = 0; beams <= 9; ++beams) {
    const sensor::LaserScan scan = RandomScan(beams, 11);
    const grid::ScanRayOptions options{.max_range = 30.0, .no_return_range = 0.0};
    const grid::ScanRays exact = grid::RaysOf(scan, Pose2{}, options);
    const grid::ScanRays rays = RobotRays(scan, options);
    EXPECT_TRUE(IsSinglePrecision(rays.origin));
    EXPECT_LT((rays.origin - exact.origin).norm(), 1e-6);
    ASSERT_EQ(rays.hits.size(), static_cast<std::size_t>(beams));
    for (std::size_t i = 0; i < rays.hits.size(); ++i) {
      EXPECT_TRUE(IsSinglePrecision(rays.hits[i])) << "point " << i << " of " << beams;
      EXPECT_LT((rays.hits[i] - exact.hits[i]).norm(), 4e-6);
    }
  }
}

TEST(RobotRays, RoundTheEndsOfBeamsWithoutReturn) {
  sensor::LaserScan scan = RandomScan(7, 3);
  for (float& range : scan.ranges) range = std::numeric_limits<float>::infinity();
  const grid::ScanRays rays = RobotRays(scan, {.max_range = 30.0, .no_return_range = 3.7});
  EXPECT_TRUE(rays.hits.empty());
  ASSERT_EQ(rays.free_ends.size(), 7U);
  for (const Eigen::Vector2d& end : rays.free_ends) {
    EXPECT_TRUE(IsSinglePrecision(end));
    EXPECT_NEAR((end - rays.origin).norm(), 3.7, 1e-5);
  }
}

grid::ScanRays SomeRays() { return {{0.5, -0.25}, {{1.0, 2.0}, {-3.0, 0.5}, {0.0, 0.0}}, {{4.0, 4.0}}}; }

TEST(Transformed, MovesOriginHitsAndFreeEnds) {
  const Pose2 T{1.0, -2.0, 0.7};
  const grid::ScanRays source = SomeRays();
  const grid::ScanRays moved = Transformed(T, source);
  EXPECT_LT((moved.origin - T * source.origin).norm(), 1e-12);
  ASSERT_EQ(moved.hits.size(), source.hits.size());
  ASSERT_EQ(moved.free_ends.size(), source.free_ends.size());
  for (std::size_t i = 0; i < moved.hits.size(); ++i) EXPECT_LT((moved.hits[i] - T * source.hits[i]).norm(), 1e-12);
  EXPECT_LT((moved.free_ends[0] - T * source.free_ends[0]).norm(), 1e-12);
}

TEST(Transformed, ThereAndBackChangesNothing) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-10.0, 10.0);
  for (int k = 0; k < 20; ++k) {
    const Pose2 T{any(random), any(random), any(random)};
    const grid::ScanRays source = SomeRays();
    const grid::ScanRays back = Transformed(Inverse(T), Transformed(T, source));
    EXPECT_LT((back.origin - source.origin).norm(), 1e-12);
    for (std::size_t i = 0; i < source.hits.size(); ++i) EXPECT_LT((back.hits[i] - source.hits[i]).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace enfilade::slam
