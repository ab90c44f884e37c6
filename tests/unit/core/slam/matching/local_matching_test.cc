// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/local_matching.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/slam/submaps/robot_rays.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using testing::PoseNear;

// A room with a pillar beside its right wall, seen all around from near its middle.
class LocalMatchingTest : public ::testing::Test {
 protected:
  void SetUp() override {
    testing::SyntheticScanner scanner;
    scanner.beams = 720;
    scanner.field_of_view = 2.0 * M_PI;
    const sensor::LaserScan scan = testing::Scan(walls_, kSeenFrom, scanner, 0, 1);
    ASSERT_OK(grid_.Insert(kSeenFrom, RobotRays(scan, {})).status());
    fields_.Rebuild(grid_);
  }

  // What a scanner that sees `range` (m) far shows of the room from `pose`, in the robot's frame.
  std::vector<Eigen::Vector2d> SeenFrom(const Pose2& pose, double range) const {
    testing::SyntheticScanner scanner;
    scanner.range_max = range;
    return RobotRays(testing::Scan(walls_, pose, scanner, 0, 2), {}).hits;
  }

  LocalMatch Match(const std::vector<Eigen::Vector2d>& hits, const Pose2& predicted) const {
    const PredictedMotion motion{predicted, 0.1, 0.07, true};  // odometry's, a metre behind
    return MatchLocally({grid_, fields_}, hits, {}, motion, options_);
  }

  static constexpr Pose2 kSeenFrom{4.5, 3.5, 0.0};

  const std::vector<testing::Wall> walls_ = testing::WallsFromText({"#########",  //
                                                                    "#       #",  //
                                                                    "#      ##",  //
                                                                    "#       #",  //
                                                                    "#       #",  //
                                                                    "#########"},
                                                                   1.0);
  const LocalMatchOptions options_;
  SubmapGrid grid_{0.05, {}};
  LocalFields fields_{0.05, options_};
};

TEST_F(LocalMatchingTest, WheelsThatSlippedAreNotBelievedAgainstTheWalls) {
  const Pose2 truth{5.5, 3.0, 0.2};
  const LocalMatch match = Match(SeenFrom(truth, 3.0), {5.6, 3.1, 0.7});  // seven standard deviations of yaw
  EXPECT_TRUE(match.good);
  EXPECT_THAT(match.match.T_submap_robot, PoseNear(truth, 0.05, 0.04));
}

// Behind a door another corner, like one of this room's: where the odometry says the robot is nothing has been seen
// yet, and so nothing contradicts it.
class BehindTheDoorTest : public LocalMatchingTest {
 protected:
  static constexpr Pose2 kLookAlike{6.5, 1.6, -0.8};
  static constexpr Pose2 kPredicted{8.4, 0.4, 0.0};  // 2.2 m and 46 degrees from the look-alike
};

TEST_F(BehindTheDoorTest, ALittleThatLooksLikeTheRoomIsLeftToTheOdometry) {
  const std::vector<Eigen::Vector2d> corner = SeenFrom(kLookAlike, 1.3);
  ASSERT_GT(corner.size(), 40U);
  ASSERT_TRUE(IsSure(Match(corner, {6.4, 1.7, -0.85}), options_)) << "all of it would fit there";
  const LocalMatch match = Match(corner, kPredicted);
  EXPECT_FALSE(match.good);
  EXPECT_THAT(match.match.T_submap_robot, PoseNear(kPredicted, 0.0, 0.0));
}

TEST_F(BehindTheDoorTest, AllOfAScanThatShowsMuchIsBelieved) {
  const LocalMatch match = Match(SeenFrom(kLookAlike, 3.0), kPredicted);
  EXPECT_TRUE(IsUnmistakable(match));
  EXPECT_THAT(match.match.T_submap_robot, PoseNear(kLookAlike, 0.05, 0.04));
}

}  // namespace
}  // namespace enfilade::slam
