// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/cloud_to_scan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/status_assertions.h"

namespace enfilade::perception {
namespace {

using ::testing::HasSubstr;

TEST(CloudToScanTest, TakesTheNearestPointOfEachBeamWithinTheHeights) {
  const Cloud cloud{{{3.0F, 0.01F, 1.0F},  // behind the next
                     {2.0F, 0.01F, 1.0F},
                     {1.0F, 0.01F, 0.4F},   // too low
                     {1.5F, 0.01F, 1.8F},   // too high
                     {0.1F, 0.001F, 1.0F},  // too near
                     {0.0F, 5.0F, 0.5F},
                     {NAN, 1.0F, 1.0F}}};
  ASSERT_OK_AND_ASSIGN(const sensor::LaserScan scan, CloudToScan(cloud, 42));
  EXPECT_EQ(scan.ranges.size(), 723U);
  EXPECT_EQ(scan.time, 42);
  EXPECT_OK(sensor::Validate(scan));
  const auto beam = [&](double angle) {
    return static_cast<std::size_t>((angle - scan.angle_min) / scan.angle_increment);
  };
  EXPECT_NEAR(scan.ranges[beam(0.005)], 2.0F, 1e-4F);
  EXPECT_NEAR(scan.ranges[beam(M_PI / 2)], 5.0F, 1e-4F);
  EXPECT_EQ(sensor::CountBeams(scan).hits, 2U);
  EXPECT_EQ(sensor::CountBeams(scan).no_returns, 721U);
}

TEST(CloudToScanTest, SeesNothingInAnEmptyCloud) {
  ASSERT_OK_AND_ASSIGN(const sensor::LaserScan infinite, CloudToScan({}, 0));
  EXPECT_TRUE(std::isinf(infinite.ranges[0]));
  CloudToScanOptions options;
  options.use_inf = false;
  ASSERT_OK_AND_ASSIGN(const sensor::LaserScan finite, CloudToScan({}, 0, options));
  EXPECT_EQ(finite.ranges[0], 101.0F);
  EXPECT_EQ(sensor::CountBeams(finite).no_returns, finite.ranges.size());
}

TEST(CloudToScanTest, PutsThePointStraightBehindIntoTheScan) {
  ASSERT_OK_AND_ASSIGN(const sensor::LaserScan scan, CloudToScan({{{-2.0F, 0.0F, 1.0F}}}, 0));
  EXPECT_EQ(sensor::CountBeams(scan).hits, 1U);
  EXPECT_NEAR(scan.ranges.back(), 2.0F, 1e-6F);
}

TEST(CloudToScanTest, NamesOptionsOutOfRange) {
  CloudToScanOptions options;
  options.angle_increment = 0.0;
  EXPECT_STATUS(CloudToScan({}, 0, options), absl::StatusCode::kInvalidArgument, HasSubstr("steps of 0"));
  options = {};
  options.range_max = 0.1;
  EXPECT_STATUS(CloudToScan({}, 0, options), absl::StatusCode::kInvalidArgument, HasSubstr("ranges"));
}

}  // namespace
}  // namespace enfilade::perception
