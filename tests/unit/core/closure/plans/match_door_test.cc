// SPDX-License-Identifier: Apache-2.0
#include "core/closure/plans/match_door.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/status_assertions.h"

namespace enfilade::closure {
namespace {

using ::testing::HasSubstr;

// Beams that hit at these points of the map, from a robot at `robot`.
PlacedScan Beams(const Pose2& robot, const std::vector<Eigen::Vector2d>& hits) {
  PlacedScan placed;
  placed.T_map_robot.pose = robot;
  sensor::LaserScan& scan = placed.scan;
  scan.angle_min = -M_PI;
  scan.angle_increment = M_PI / 1800.0;
  scan.range_min = 0.1F;
  scan.range_max = 100.0F;
  scan.ranges.assign(3600, std::numeric_limits<float>::quiet_NaN());
  for (const Eigen::Vector2d& hit : hits) {
    const Eigen::Vector2d d = Inverse(robot) * hit;
    const double index = std::round((std::atan2(d.y(), d.x()) - scan.angle_min) / scan.angle_increment);
    scan.ranges[static_cast<std::size_t>(index) % 3600] = static_cast<float>(d.norm());
  }
  return placed;
}

TEST(PointsThroughDoor, AreThoseWhoseBeamsCrossTheOpening) {
  const Pose2 door{3.0, 1.0, M_PI_2};  // it leads north
  const Pose2 robot{3.0, -1.0, 0.4};
  const std::vector<Eigen::Vector2d> hits = {
      {3.2, 5.0},   // straight through
      {3.8, 4.0},   // through, aside
      {5.0, 4.0},   // crosses the plane 0.8 m beside the middle: through another door
      {3.1, 1.2},   // the frame
      {3.4, -3.0},  // behind the robot
  };
  const std::vector<Eigen::Vector2d> points = PointsThroughDoor({Beams(robot, hits)}, door, 1.0);
  ASSERT_EQ(points.size(), 2U);
  for (const Eigen::Vector2d& expected : {hits[0], hits[1]}) {
    const Eigen::Vector2d in_door = Inverse(door) * expected;
    const auto near = [&](const Eigen::Vector2d& point) { return (point - in_door).norm() < 0.02; };
    EXPECT_TRUE(near(points[0]) || near(points[1]));
  }
}

TEST(PointsThroughDoor, ARobotThatIsThroughSeesNothingThroughIt) {
  EXPECT_TRUE(PointsThroughDoor({Beams({3.0, 1.5, 0.0}, {{3.0, 5.0}})}, {3.0, 1.0, M_PI_2}, 1.0).empty());
}

class JudgeDoorScansTest : public ::testing::Test {
 protected:
  static ScanLocation Found(const Pose2& pose, double sigma) {
    ScanLocation location{.accepted = true, .T_map_robot = {pose, {}}, .matched_share = 0.8, .reason = "it fits"};
    location.T_map_robot.covariance = Eigen::Vector3d(sigma * sigma, sigma * sigma, 1e-4).asDiagonal();
    return location;
  }
  static ScanLocation Nothing() { return {.reason = "too few points"}; }
  static ScanLocation Elsewhere() { return {.matched_share = 0.7, .reason = "it fits 2 m aside"}; }

  const DoorInMaps door_{{4.0, 1.0, 0.5}, {-3.0, 2.0, -2.0}};
  const DoorClosureOptions options_;
};

TEST_F(JudgeDoorScansTest, OneDirectionIsEnough) {
  const Pose2 there{-2.9, 2.05, -1.98};
  const DoorMatch forth = JudgeDoorScans(Found(there, 0.05), Nothing(), door_, options_);
  ASSERT_TRUE(forth.T_there_door);
  EXPECT_EQ(forth.T_there_door->pose, there);
  EXPECT_FALSE(forth.contradicted);
  // What the others see says the same: where their door is here tells where ours is there.
  const Pose2 T_there_here = there * Inverse(door_.T_here_door);
  const Pose2 theirs = Inverse(T_there_here) * door_.T_there_door;
  const DoorMatch back = JudgeDoorScans(Nothing(), Found(theirs, 0.05), door_, options_);
  ASSERT_TRUE(back.T_there_door);
  EXPECT_NEAR((back.T_there_door->pose.translation() - there.translation()).norm(), 0.0, 1e-9);
  EXPECT_NEAR(WrapAngle(back.T_there_door->pose.yaw - there.yaw), 0.0, 1e-9);

  const DoorMatch both = JudgeDoorScans(Found(there, 0.05), Found(theirs, 0.02), door_, options_);
  ASSERT_TRUE(both.T_there_door);
  EXPECT_LT(both.T_there_door->covariance(0, 0), 0.04 * 0.04) << "the surer one counts";
  EXPECT_THAT(both.reason, HasSubstr("chi-squared 0.0"));
}

TEST_F(JudgeDoorScansTest, WithoutAnyThereIsNoMatch) {
  const DoorMatch match = JudgeDoorScans(Nothing(), Nothing(), door_, options_);
  EXPECT_FALSE(match.T_there_door);
  EXPECT_FALSE(match.contradicted);
  EXPECT_THAT(match.reason, HasSubstr("too few points"));
}

TEST_F(JudgeDoorScansTest, DirectionsThatContradictEachOtherDecideNothing) {
  EXPECT_FALSE(JudgeDoorScans(Found(door_.T_there_door, 0.05), Elsewhere(), door_, options_).T_there_door);
  EXPECT_TRUE(JudgeDoorScans(Elsewhere(), Found(door_.T_here_door, 0.05), door_, options_).contradicted);
  // Both found, 1 m apart.
  const Pose2 aside = door_.T_here_door * Pose2{0.0, 1.0, 0.0};
  const DoorMatch match = JudgeDoorScans(Found(door_.T_there_door, 0.03), Found(aside, 0.03), door_, options_);
  EXPECT_TRUE(match.contradicted);
  EXPECT_FALSE(match.T_there_door);
}

// Two maps whose link points lead through a third: far from the world's root, but near each other.
TEST(PredictBetween, HasTheCovarianceOfOneMapRelativeToTheOther) {
  graph::SnapshotChanges changes{.version = 1, .root = MapId("a")};
  for (const char* id : {"a", "b", "c", "d"}) changes.maps.push_back({.id = MapId(id), .display_name = id});
  const auto link = [&](const std::string& id, const std::string& from, const std::string& to, double sigma) {
    graph::LinkPoint point;
    point.id = LinkPointId(id);
    const Eigen::Matrix3d covariance = Eigen::Vector3d(sigma * sigma, sigma * sigma, 1e-4).asDiagonal();
    point.anchors = {{MapId(from), {3.0, 0.0, 0.0}, covariance}, {MapId(to), {-3.0, 0.0, 0.0}, covariance}};
    changes.link_points.push_back(point);
  };
  link("ab", "a", "b", 1.0);
  link("bc", "b", "c", 0.02);
  const auto graph = graph::Apply(graph::GraphSnapshot(), changes);
  ASSERT_OK(graph);
  const auto near = PredictBetween(*graph, MapId("b"), MapId("c"));
  ASSERT_OK(near);
  ASSERT_TRUE(near->has_value());
  EXPECT_NEAR((*near)->pose.x, 6.0, 1e-6);
  EXPECT_LT((*near)->covariance(0, 0), 0.01) << "a, the root, is not part of it";
  const auto apart = PredictBetween(*graph, MapId("b"), MapId("d"));
  ASSERT_OK(apart);
  EXPECT_FALSE(apart->has_value());
}

}  // namespace
}  // namespace enfilade::closure
