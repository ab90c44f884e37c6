// SPDX-License-Identifier: Apache-2.0
#include "core/sensor/scan_box.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/environment.h"
#include "core/sensor/environment_choice.h"
#include "tests/support/status_assertions.h"

namespace enfilade::sensor {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::Optional;

constexpr float kInf = std::numeric_limits<float>::infinity();
const float kNan = std::numeric_limits<float>::quiet_NaN();

LaserScan Scan(std::vector<float> ranges, double angle_min, double increment) {
  LaserScan scan;
  scan.angle_min = angle_min;
  scan.angle_increment = increment;
  scan.range_min = 0.1F;
  scan.range_max = 100.0F;
  scan.ranges = std::move(ranges);
  return scan;
}

// A rectangle of walls around the scanner, a full turn in half degrees.
LaserScan InRectangle(double front, double back, double left, double right) {
  LaserScan scan = Scan({}, -M_PI, M_PI / 360.0);
  for (int i = 0; i < 720; ++i) {
    const double angle = scan.angle(static_cast<std::size_t>(i));
    const double x = std::cos(angle) > 0.0 ? front / std::cos(angle) : -back / std::cos(angle);
    const double y = std::sin(angle) > 0.0 ? left / std::sin(angle) : -right / std::sin(angle);
    scan.ranges.push_back(static_cast<float>(std::min(std::abs(x), std::abs(y))));
  }
  return scan;
}

TEST(MeanFilteredRangesTest, AveragesHitsOnly) {
  const LaserScan scan = Scan({1.0F, kInf, 3.0F, kNan, -1.0F, 0.05F, 5.0F}, 0.0, 0.1);
  EXPECT_THAT(MeanFilteredRanges(scan, 1), ElementsAre(Optional(1.0), Optional(2.0), Optional(3.0), Optional(3.0),
                                                       std::nullopt, Optional(5.0), Optional(5.0)));
}

TEST(MeanFilteredRangesTest, WrapsAroundAFullTurn) {
  const LaserScan scan = Scan({1.0F, 2.0F, 3.0F, 6.0F}, 0.0, M_PI / 2.0);
  EXPECT_THAT(MeanFilteredRanges(scan, 1),
              ElementsAre(Optional(3.0), Optional(2.0), Optional(DoubleNear(11.0 / 3.0, 1e-9)),
                          Optional(DoubleNear(10.0 / 3.0, 1e-9))));
  EXPECT_THAT(MeanFilteredRanges(scan, 60), ElementsAre(Optional(3.0), Optional(3.0), Optional(3.0), Optional(3.0)));
}

TEST(MeanFilteredRangesTest, TakesScansShorterThanItsWindow) {
  EXPECT_THAT(MeanFilteredRanges(Scan({2.0F}, 0.0, 0.01), 60), ElementsAre(Optional(2.0)));
  EXPECT_THAT(MeanFilteredRanges(Scan({2.0F, 4.0F}, 0.0, 0.01), 60), ElementsAre(Optional(3.0), Optional(3.0)));
  EXPECT_TRUE(MeanFilteredRanges(Scan({}, 0.0, 0.01), 60).empty());
}

TEST(FilteredBoxTest, BoundsTheRoomInTheGivenFrame) {
  const Eigen::AlignedBox2d box = FilteredBox(InRectangle(4.0, 4.0, 2.0, 2.0), 0);
  EXPECT_NEAR(box.max().x(), 4.0, 1e-3);
  EXPECT_NEAR(box.min().y(), -2.0, 1e-3);
  const Eigen::AlignedBox2d turned = FilteredBox(InRectangle(4.0, 4.0, 2.0, 2.0), 0, {10.0, 0.0, M_PI / 2.0});
  EXPECT_NEAR(turned.max().x(), 12.0, 1e-3);
  EXPECT_NEAR(turned.max().y(), 4.0, 1e-3);
  EXPECT_TRUE(FilteredBox(Scan({kInf, kInf}, 0.0, 0.1), 5).isEmpty());
}

TEST(ChooseByRangeTest, AsksForTwoFarSides) {
  const auto choose = [](const LaserScan& scan) { return ChooseByRange(scan).value(); };
  EXPECT_EQ(choose(InRectangle(5.0, 5.0, 4.0, 4.0)).environment, Environment::kIndoor);
  EXPECT_EQ(choose(InRectangle(40.0, 3.0, 3.0, 3.0)).far_sides, 1);
  EXPECT_EQ(choose(InRectangle(40.0, 40.0, 30.0, 30.0)).environment, Environment::kOutdoor);
  const RangeChoice nothing = choose(Scan(std::vector<float>(720, kInf), -M_PI, M_PI / 360.0));
  EXPECT_EQ(nothing.environment, std::nullopt);
}

// 12 m around: beyond the limit of the code's defaults, within that of params.yaml.
TEST(ChooseByRangeTest, HasBothOfMapManagersPresets) {
  const LaserScan scan = InRectangle(12.0, 12.0, 12.0, 12.0);
  EXPECT_EQ(ChooseByRange(scan, RangeCriterion::MapManagerYaml())->environment, Environment::kIndoor);
  EXPECT_EQ(ChooseByRange(scan, RangeCriterion::MapManagerCode())->environment, Environment::kOutdoor);
  EXPECT_CODE(ChooseByRange(scan, {.side_limit = -1.0}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(ChooseByRange(LaserScan{}), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace enfilade::sensor
