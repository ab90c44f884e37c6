// SPDX-License-Identifier: Apache-2.0
#include "core/areas/map_area.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/areas/simple_polygon.h"
#include "core/geometry/pose2.h"
#include "tests/support/status_assertions.h"

namespace enfilade::areas {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;
using ::testing::StartsWith;

MapArea Square() {
  MapArea area;
  area.display_name = "Lab bench";
  area.outline = {{0, 0}, {2, 0}, {2, 2}, {0, 2}};
  return area;
}

void ExpectRefused(const MapArea& area, const ::testing::Matcher<std::string>& message) {
  EXPECT_STATUS(Validate(area), absl::StatusCode::kInvalidArgument, message);
}

TEST(MapArea, KindsHaveNames) {
  for (int number = 1; number <= 6; ++number) {
    const auto kind = static_cast<AreaKind>(number);
    EXPECT_EQ(KindOfName(NameOfKind(kind)), kind);
  }
  EXPECT_EQ(KindNames().size(), 6U);
  EXPECT_FALSE(KindOfName("lava").has_value());
}

TEST(MapArea, OutlinesAreSimplePolygonsOf3To1000Corners) {
  EXPECT_OK(Validate(Square()));
  MapArea area = Square();
  area.outline.resize(2);
  ExpectRefused(area, StartsWith("outline has 2 corners: expected 3 to 1000"));
  area.outline.clear();
  for (int i = 0; i < 1000; ++i) area.outline.emplace_back(std::cos(i * M_PI / 500), std::sin(i * M_PI / 500));
  EXPECT_OK(Validate(area));
  area.outline.emplace_back(0.5, -0.001);
  ExpectRefused(area, StartsWith("outline has 1001 corners"));
}

TEST(MapArea, OutlinesThatAreNotSimpleAreRefusedByName) {
  MapArea area = Square();
  std::swap(area.outline[1], area.outline[2]);
  ExpectRefused(area, StartsWith("outline: sides 0 and 2 cross or touch"));
  area.outline = {{0, 0}, {4, 0}, {2, 0}, {2, 2}};
  ExpectRefused(area, HasSubstr("side 1 goes back along side 0 at (4, 0)"));
  area.outline = {{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}};
  ExpectRefused(area, HasSubstr("sides 0 and 2 cross or touch"));
  area.outline = {{0, 0}, {4, 0}, {4, 0}, {2, 2}};
  ExpectRefused(area, HasSubstr("corners 1 and 2 are at one place, (4, 0)"));
  area.outline = {{0, 0}, {4, 0}, {2, 2}, {0, 0}};
  ExpectRefused(area, HasSubstr("corners 3 and 0 are at one place"));
  area.outline = {{0, 0}, {1, 0}, {2, 0}};
  ExpectRefused(area, HasSubstr("goes back along"));
  area.outline = {{0, 0}, {1, 0}, {std::numeric_limits<double>::quiet_NaN(), 1}};
  ExpectRefused(area, HasSubstr("corner 2 is not finite"));
  area.outline = {{0, 0}, {1, 0}, {1, 2e6}};
  ExpectRefused(area, HasSubstr("corner 2 is at (1, 2000000)"));
}

TEST(MapArea, ASimpleOutlineStaysSimpleInAnotherFrame) {
  // A comb whose teeth are thin, far away from the origin.
  std::vector<Vector2d> comb;
  for (int tooth = 0; tooth < 50; ++tooth) {
    comb.emplace_back(tooth, 0.0);
    comb.emplace_back(tooth + 1e-5, 10.0);
    comb.emplace_back(tooth + 2e-5, 0.0);
  }
  comb.emplace_back(50.0, -1.0);
  comb.emplace_back(-1.0, -1.0);
  ASSERT_OK(ValidateSimplePolygon(comb, kMaxAreaCoordinate));
  for (int degrees = 1; degrees < 360; degrees += 17) {
    const Pose2 T_other_map{9e5, -9e5, degrees * kDegree};
    std::vector<Vector2d> moved;
    for (const Vector2d& corner : comb) moved.push_back(T_other_map * corner);
    EXPECT_OK(ValidateSimplePolygon(moved, 2 * kMaxAreaCoordinate)) << degrees;
  }
}

TEST(MapArea, RobotTypesAreIds) {
  MapArea area = Square();
  area.robot_types = {"forklift", "Cleaner"};
  ExpectRefused(area, StartsWith("robot_types[1] is \"Cleaner\": expected 1 to 63"));
  area.robot_types = {"forklift", "cleaner", "forklift"};
  ExpectRefused(area, StartsWith("robot_types[2] is \"forklift\", which was named before"));
  area.robot_types.clear();
  for (int i = 0; i < 21; ++i) area.robot_types.push_back("r" + std::to_string(i));
  ExpectRefused(area, StartsWith("robot_types has 21 types"));
  area.robot_types.pop_back();
  EXPECT_OK(Validate(area));
}

TEST(MapArea, OnlySpeedLimitsHaveASpeed) {
  MapArea area = Square();
  area.speed_limit_mps = 0.5;
  ExpectRefused(area, StartsWith("speed_limit_mps is 0.5: only an area of the kind speed-limit"));
  area.kind = AreaKind::kSpeedLimit;
  EXPECT_OK(Validate(area));
  for (const double speed :
       {0.0, -1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    area.speed_limit_mps = speed;
    ExpectRefused(area, HasSubstr("expected metres per second, more than 0"));
  }
}

TEST(MapArea, HoldsFromAndBeforeATimeForItsRobotTypes) {
  MapArea area = Square();
  EXPECT_TRUE(HoldsFor(area, "", 5));
  EXPECT_TRUE(HoldsFor(area, "cleaner", 5));
  area.valid_from = 10;
  area.valid_until = 20;
  area.robot_types = {"forklift"};
  EXPECT_FALSE(HoldsFor(area, "forklift", 9));
  EXPECT_TRUE(HoldsFor(area, "forklift", 10));
  EXPECT_TRUE(HoldsFor(area, "forklift", 19));
  EXPECT_FALSE(HoldsFor(area, "forklift", 20));
  EXPECT_TRUE(HoldsFor(area, "forklift", std::nullopt));
  EXPECT_TRUE(HoldsFor(area, "", 15)) << "no type: areas for all types";
  EXPECT_FALSE(HoldsFor(area, "cleaner", 15));
  EXPECT_OK(Validate(area));
  area.valid_from = 20;
  ExpectRefused(area, StartsWith("valid_until is not after valid_from"));
}

}  // namespace
}  // namespace enfilade::areas
