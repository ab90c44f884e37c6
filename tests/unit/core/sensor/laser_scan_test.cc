// SPDX-License-Identifier: Apache-2.0
#include "core/sensor/laser_scan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/status_assertions.h"

namespace enfilade::sensor {
namespace {

using ::testing::HasSubstr;

LaserScan ValidScan() {
  LaserScan scan;
  scan.angle_min = -M_PI / 2.0;
  scan.angle_increment = M_PI / 4.0;
  scan.range_min = 0.1F;
  scan.range_max = 10.0F;
  scan.ranges = {1.0F, 2.0F, 3.0F, 4.0F};
  return scan;
}

TEST(LaserScan, CountsHitsNoReturnsAndUnknownBeams) {
  LaserScan scan = ValidScan();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  scan.ranges = {1.0F, 0.1F, 0.05F, -3.0F, std::nanf(""), -kInf, 10.0F, 81.83F, kInf};
  const BeamCounts counts = CountBeams(scan);
  EXPECT_EQ(counts.hits, 2U);
  EXPECT_EQ(counts.no_returns, 3U);
  EXPECT_EQ(counts.unknown, 4U);
  EXPECT_OK(Validate(scan));
}

TEST(LaserScan, HitPointsAreInTheRobotsFrame) {
  LaserScan scan = ValidScan();
  scan.T_robot_laser = {0.5, 0.0, M_PI / 2.0};
  const auto points = HitPoints(scan, 3.5);
  ASSERT_EQ(points.size(), 3U);
  EXPECT_NEAR(points[0].x(), 1.5, 1e-6);
  EXPECT_NEAR(points[0].y(), 0.0, 1e-6);
}

TEST(LaserScan, RefusesImplausibleScans) {
  const auto refused = [](auto change, const char* field) {
    LaserScan scan = ValidScan();
    change(scan);
    EXPECT_STATUS(Validate(scan), absl::StatusCode::kInvalidArgument, HasSubstr(field));
  };
  refused([](LaserScan& s) { s.ranges.clear(); }, "ranges is empty");
  refused([](LaserScan& s) { s.ranges.assign(1'000'000, 1.0F); }, "1000000 beams");
  refused([](LaserScan& s) { s.angle_increment = 0.0; }, "angle_increment");
  refused([](LaserScan& s) { s.angle_min = NAN; }, "angle_min");
  refused([](LaserScan& s) { s.range_max = 0.05F; }, "range limits");
  refused([](LaserScan& s) { s.T_robot_laser.x = INFINITY; }, "mount");
  refused([](LaserScan& s) { s.T_robot_laser.y = -5000.0; }, "mount");
}

}  // namespace
}  // namespace enfilade::sensor
