// SPDX-License-Identifier: Apache-2.0
#include "core/grid/scan_rays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace enfilade::grid {
namespace {

constexpr float kInfiniteRange = std::numeric_limits<float>::infinity();
constexpr float kNanRange = std::numeric_limits<float>::quiet_NaN();

sensor::LaserScan ScanOf(std::vector<float> ranges) {
  sensor::LaserScan scan;
  scan.angle_increment = M_PI / 2.0;
  scan.range_min = 0.1F;
  scan.range_max = 50.0F;
  scan.ranges = std::move(ranges);
  return scan;
}

TEST(ScanRays, PutsHitsWhereTheBeamsPoint) {
  sensor::LaserScan scan = ScanOf({2.0F, 3.0F});
  scan.T_robot_laser = {0.5, 0.0, 0.0};
  const ScanRays rays = RaysOf(scan, {10.0, 20.0, M_PI / 2.0}, {});
  EXPECT_TRUE(rays.origin.isApprox(Eigen::Vector2d(10.0, 20.5)));
  ASSERT_EQ(rays.hits.size(), 2U);
  EXPECT_TRUE(rays.hits[0].isApprox(Eigen::Vector2d(10.0, 22.5)));
  EXPECT_TRUE(rays.hits[1].isApprox(Eigen::Vector2d(7.0, 20.5)));
  EXPECT_TRUE(rays.free_ends.empty());
}

TEST(ScanRays, CutsFarHitsToFreeSpace) {
  const ScanRays rays = RaysOf(ScanOf({40.0F}), {}, {.max_range = 30.0});
  EXPECT_TRUE(rays.hits.empty());
  ASSERT_EQ(rays.free_ends.size(), 1U);
  EXPECT_TRUE(rays.free_ends[0].isApprox(Eigen::Vector2d(30.0, 0.0)));
}

TEST(ScanRays, TakesNoReturnAsFreeForAShortWay) {
  const ScanRays rays = RaysOf(ScanOf({kInfiniteRange, 50.0F}), {}, {.no_return_range = 5.0});
  EXPECT_TRUE(rays.hits.empty());
  ASSERT_EQ(rays.free_ends.size(), 2U);
  EXPECT_NEAR(rays.free_ends[0].norm(), 5.0, 1e-12);
}

TEST(ScanRays, IgnoresBeamsWithoutReturnIfSwitchedOff) {
  EXPECT_TRUE(RaysOf(ScanOf({kInfiniteRange}), {}, {.no_return_range = 0.0}).free_ends.empty());
}

TEST(ScanRays, SkipsBeamsWithoutInformation) {
  const ScanRays rays = RaysOf(ScanOf({kNanRange, -kInfiniteRange, 0.05F, -1.0F}), {}, {});
  EXPECT_TRUE(rays.hits.empty());
  EXPECT_TRUE(rays.free_ends.empty());
}

}  // namespace
}  // namespace enfilade::grid
