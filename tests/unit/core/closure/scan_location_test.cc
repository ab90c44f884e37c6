// SPDX-License-Identifier: Apache-2.0
#include "core/closure/scan_location.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace enfilade::closure {
namespace {

using ::testing::HasSubstr;

struct Wall {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

void AddBox(double x0, double y0, double x1, double y1, std::vector<Wall>& walls) {
  const std::vector<Eigen::Vector2d> corners = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
  for (std::size_t i = 0; i < 4; ++i) walls.push_back({corners[i], corners[(i + 1) % 4]});
}

// 9 m x 7 m with a table and a cupboard: no two places in it look the same.
std::vector<Wall> Room() {
  std::vector<Wall> walls;
  AddBox(0, 0, 9, 7, walls);
  AddBox(6, 4.5, 7.5, 5.5, walls);
  AddBox(0, 5, 0.6, 7, walls);
  return walls;
}

std::vector<Wall> Corridor() {
  std::vector<Wall> walls;
  AddBox(-40, 0, 40, 2.5, walls);
  return walls;
}

PlacedScan ScanIn(const std::vector<Wall>& walls, const Pose2& pose, double sigma = 0.01) {
  PlacedScan placed;
  placed.T_map_robot = {pose, Eigen::Vector3d(sigma * sigma, sigma * sigma, 1e-6).asDiagonal()};
  sensor::LaserScan& scan = placed.scan;
  scan.time = 1;
  scan.angle_min = -M_PI;
  scan.angle_increment = M_PI / 180.0;
  scan.range_min = 0.1F;
  scan.range_max = 100.0F;
  for (int i = 0; i < 360; ++i) {
    const double angle = pose.yaw + scan.angle_min + i * scan.angle_increment;
    const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Wall& wall : walls) {
      const Eigen::Vector2d along = wall.to - wall.from;
      const Eigen::Vector2d from = wall.from - pose.translation();
      const double cross = ray.x() * along.y() - ray.y() * along.x();
      if (std::abs(cross) < 1e-12) continue;
      const double range = (from.x() * along.y() - from.y() * along.x()) / cross;
      const double share = (from.x() * ray.y() - from.y() * ray.x()) / cross;
      if (range > 0.0 && share >= 0.0 && share <= 1.0) nearest = std::min(nearest, range);
    }
    scan.ranges.push_back(static_cast<float>(nearest));
  }
  return placed;
}

std::vector<PlacedScan> SeenAlong(const std::vector<Wall>& walls, double y) {
  std::vector<PlacedScan> scans;
  for (double x = 2.0; x <= 5.0; x += 0.5) scans.push_back(ScanIn(walls, {x, y, 0.1}));
  return scans;
}

std::vector<Eigen::Vector2d> PointsOf(const std::vector<Wall>& walls, const Pose2& robot) {
  return PointsBehindDoor({ScanIn(walls, robot)}, {-1000.0, 0.0, 0.0}, robot);
}

PoseWithCovariance Guess(const Pose2& pose, double sigma = 0.3, double yaw_sigma = 0.05) {
  return {pose, Eigen::Vector3d(sigma * sigma, sigma * sigma, yaw_sigma * yaw_sigma).asDiagonal()};
}

ScanLocation Locate(const std::vector<PlacedScan>& known, const std::vector<Eigen::Vector2d>& points,
                    const PoseWithCovariance& predicted, const DoorClosureOptions& options) {
  const SeenGround seen(known);
  return LocateByScans(&seen, points, predicted, options);
}

TEST(ScanLocation, FindsTheRobotFromAnotherSideOfTheRoom) {
  const Pose2 robot{7.0, 2.0, 2.0};
  const ScanLocation found =
      Locate(SeenAlong(Room(), 3.0), PointsOf(Room(), robot), Guess({7.4, 1.7, 2.06}), DoorClosureOptions());
  ASSERT_TRUE(found.accepted) << found.reason;
  EXPECT_LT((found.T_map_robot.pose.translation() - robot.translation()).norm(), 0.05);
  EXPECT_LT(std::abs(found.T_map_robot.pose.yaw - robot.yaw), 0.01);
  EXPECT_GT(found.T_map_robot.covariance(0, 0), 1e-4);  // at least that of the map's own scans there
}

TEST(ScanLocation, AnotherRoomIsNotTakenForIt) {
  std::vector<Wall> other;
  AddBox(0, 0, 6, 5, other);
  AddBox(2, 2, 3, 2.6, other);
  const ScanLocation found =
      Locate(SeenAlong(Room(), 3.0), PointsOf(other, {4.5, 1.2, 1.0}), Guess({6.5, 2.5, 1.0}), DoorClosureOptions());
  EXPECT_FALSE(found.accepted) << found.reason;
}

TEST(ScanLocation, ACorridorDoesNotSayWhereAlongItTheRobotIs) {
  const ScanLocation found = Locate(SeenAlong(Corridor(), 1.2), PointsOf(Corridor(), {6.0, 1.2, 0.0}),
                                    Guess({6.3, 1.2, 0.0}), DoorClosureOptions());
  EXPECT_FALSE(found.accepted) << found.reason;
}

TEST(ScanLocation, NoSearchIsMadeIfTheGraphCannotTellRoomsApart) {
  const Pose2 robot{7.0, 2.0, 2.0};
  const ScanLocation far =
      Locate(SeenAlong(Room(), 3.0), PointsOf(Room(), robot), Guess(robot, 1.5), DoorClosureOptions());
  EXPECT_FALSE(far.accepted);
  EXPECT_THAT(far.reason, HasSubstr("not sure enough"));
  const ScanLocation turned =
      Locate(SeenAlong(Room(), 3.0), PointsOf(Room(), robot), Guess(robot, 0.1, 0.5), DoorClosureOptions());
  EXPECT_FALSE(turned.accepted);
}

// The same room once more, next door, would look as this one does.
TEST(ScanLocation, APoseThatMayBeThatOfALookAlikeIsNotBelieved) {
  const Pose2 robot{7.0, 2.0, 2.0};
  const std::vector<Eigen::Vector2d> points = PointsOf(Room(), robot);
  const ScanLocation near = Locate(SeenAlong(Room(), 3.0), points, Guess({6.8, 2.2, 2.0}, 0.5), DoorClosureOptions());
  EXPECT_TRUE(near.accepted) << near.reason;
  const ScanLocation far = Locate(SeenAlong(Room(), 3.0), points, Guess({5.6, 2.2, 2.0}, 0.5), DoorClosureOptions());
  EXPECT_FALSE(far.accepted) << far.reason;
}

TEST(ScanLocation, APoseThatTheGraphRulesOutIsNotBelieved) {
  const Pose2 robot{7.0, 2.0, 2.0};
  const ScanLocation found =
      Locate(SeenAlong(Room(), 3.0), PointsOf(Room(), robot), Guess({5.5, 3.0, 2.0}, 0.1), DoorClosureOptions());
  EXPECT_FALSE(found.accepted) << found.reason;
}

TEST(ScanLocation, NothingIsFoundWhereNoRobotHasBeen) {
  const Pose2 robot{7.0, 2.0, 2.0};
  EXPECT_FALSE(Locate({}, PointsOf(Room(), robot), Guess(robot), DoorClosureOptions()).accepted);
  EXPECT_FALSE(LocateByScans(nullptr, PointsOf(Room(), robot), Guess(robot), DoorClosureOptions()).accepted);
  EXPECT_FALSE(Locate(SeenAlong(Room(), 3.0), {}, Guess(robot), DoorClosureOptions()).accepted);
}

// A robot behind a door sees the room that it has left through it.
TEST(ScanLocation, WhatLiesBeforeTheDoorIsNotOfTheMapBehindIt) {
  const Pose2 robot{2.0, 3.0, 0.0};
  const std::vector<Eigen::Vector2d> points = PointsBehindDoor({ScanIn(Room(), robot)}, {1.0, 3.0, 0.0}, robot);
  ASSERT_FALSE(points.empty());
  for (const Eigen::Vector2d& point : points) EXPECT_GE((robot * point).x(), 0.69);
}

// A robot before an open door sees half the next room.
TEST(ScanLocation, WhatIsSeenThroughADoorIsNotOfTheMap) {
  const Pose2 robot{4.0, 3.0, 0.7};
  const Pose2 door{6.0, 3.0, 0.0};
  const PlacedScan whole = ScanIn(Room(), robot);
  const std::vector<PlacedScan> cut = RemoveHitsThroughDoors({whole}, {door});
  int removed = 0;
  for (std::size_t i = 0; i < whole.scan.ranges.size(); ++i) {
    const double angle = robot.yaw + whole.scan.angle(i);
    const Eigen::Vector2d hit =
        robot.translation() + whole.scan.ranges[i] * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const double y = robot.y + std::tan(angle) * 2.0;  // where the beam crosses the door's plane
    const bool is_beyond = hit.x() > 6.0 && std::abs(y - 3.0) <= 1.0;
    EXPECT_EQ(std::isnan(cut[0].scan.ranges[i]), is_beyond) << hit.transpose();
    removed += is_beyond ? 1 : 0;
  }
  EXPECT_GT(removed, 20);
  // Whichever way the door's pose looks.
  const std::vector<PlacedScan> turned = RemoveHitsThroughDoors({whole}, {{6.0, 3.0, M_PI}});
  for (std::size_t i = 0; i < whole.scan.ranges.size(); ++i) {
    EXPECT_EQ(std::isnan(turned[0].scan.ranges[i]), std::isnan(cut[0].scan.ranges[i]));
  }
}

// A robot in the doorway sees both rooms, and with a pose that is some cm off no beam has crossed the door.
TEST(ScanLocation, AScanFromTheDoorwayShowsNeitherMap) {
  const Pose2 door{6.0, 3.0, 0.0};
  const std::vector<PlacedScan> scans = {ScanIn(Room(), {5.0, 3.0, 0.0}), ScanIn(Room(), {5.6, 3.1, 0.0}),
                                         ScanIn(Room(), {6.02, 3.0, 0.0}), ScanIn(Room(), {6.0, 3.7, 0.0})};
  const std::vector<PlacedScan> kept = RemoveHitsThroughDoors(scans, {door});
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0].T_map_robot.pose.x, 5.0);
  EXPECT_EQ(kept[1].T_map_robot.pose.y, 3.7);
}

// The frame of the map is arbitrary: a search in a moved map must find the robot at the moved pose.
TEST(ScanLocation, FollowsTheFrameOfTheMap) {
  const Pose2 robot{7.0, 2.0, 2.0};
  const std::vector<Eigen::Vector2d> points = PointsOf(Room(), robot);
  const std::vector<PlacedScan> known = SeenAlong(Room(), 3.0);
  for (const Pose2& move : {Pose2{30, -8, 0}, Pose2{-3.37, 12.21, 1.1}, Pose2{0, 0, -2.6}}) {
    std::vector<PlacedScan> moved = known;
    for (PlacedScan& one : moved) one.T_map_robot.pose = move * one.T_map_robot.pose;
    const ScanLocation found = Locate(moved, points, Guess(move * Pose2{7.3, 1.8, 2.04}), DoorClosureOptions());
    ASSERT_TRUE(found.accepted) << found.reason;
    const Pose2 expected = move * robot;
    EXPECT_LT((found.T_map_robot.pose.translation() - expected.translation()).norm(), 0.06) << found.reason;
    EXPECT_LT(std::abs(WrapAngle(found.T_map_robot.pose.yaw - expected.yaw)), 0.01);
  }
}

TEST(ScanLocation, FindsTheRobotWhereverThePredictionErrs) {
  const Pose2 robot{7.0, 2.0, 2.0};
  const std::vector<Eigen::Vector2d> points = PointsOf(Room(), robot);
  const std::vector<PlacedScan> known = SeenAlong(Room(), 3.0);
  for (const Pose2& error : {Pose2{0.6, 0, 0}, Pose2{-0.6, 0, 0}, Pose2{0, 0.6, 0.1}, Pose2{0.3, -0.5, -0.1}}) {
    const Pose2 guess{robot.x + error.x, robot.y + error.y, robot.yaw + error.yaw};
    const ScanLocation found = Locate(known, points, Guess(guess), DoorClosureOptions());
    ASSERT_TRUE(found.accepted) << found.reason;
    EXPECT_LT((found.T_map_robot.pose.translation() - robot.translation()).norm(), 0.05) << found.reason;
  }
}

TEST(ScanLocation, TheShareOfMatchedHitsIsAThreshold) {
  const Pose2 robot{7.0, 2.0, 2.0};
  const std::vector<Eigen::Vector2d> points = PointsOf(Room(), robot);
  DoorClosureOptions options;
  const ScanLocation found = Locate(SeenAlong(Room(), 3.0), points, Guess(robot), options);
  ASSERT_TRUE(found.accepted) << found.reason;
  EXPECT_GT(found.matched_share, options.locate_min_share);
  options.locate_min_share = found.matched_share + 0.01;
  EXPECT_FALSE(Locate(SeenAlong(Room(), 3.0), points, Guess(robot), options).accepted);
  options.locate_min_share = found.matched_share - 0.01;
  EXPECT_TRUE(Locate(SeenAlong(Room(), 3.0), points, Guess(robot), options).accepted);
}

TEST(ScanLocation, CloserLookAlikesNeedABetterPrediction) {
  const Pose2 robot{7.0, 2.0, 2.0};
  const std::vector<Eigen::Vector2d> points = PointsOf(Room(), robot);
  DoorClosureOptions options;
  const PoseWithCovariance guess = Guess({6.6, 2.0, 2.0}, 0.3);  // 0.7 m, 95 %, and 0.4 m off
  EXPECT_TRUE(Locate(SeenAlong(Room(), 3.0), points, guess, options).accepted);
  options.alike_distance = 1.0;
  EXPECT_FALSE(Locate(SeenAlong(Room(), 3.0), points, guess, options).accepted) << "0.4 m + 0.7 m";
  options.alike_distance = 0.6;
  EXPECT_THAT(Locate(SeenAlong(Room(), 3.0), points, guess, options).reason, HasSubstr("not sure enough"));
}

TEST(ScanLocation, PointsOfSeveralScansAreInTheFrameOfTheReport) {
  const Pose2 report{3.0, 3.0, 0.4};
  const std::vector<Eigen::Vector2d> alone = PointsBehindDoor({ScanIn(Room(), report)}, {-100, 0, 0}, report);
  const std::vector<Eigen::Vector2d> both =
      PointsBehindDoor({ScanIn(Room(), report), ScanIn(Room(), {2.0, 3.5, -0.7})}, {-100, 0, 0}, report);
  EXPECT_EQ(both.size(), 2 * alone.size());
  // All of them lie on the room's walls, table and cupboard.
  for (const Eigen::Vector2d& point : both) {
    const Eigen::Vector2d in_room = report * point;
    double nearest = std::numeric_limits<double>::infinity();
    for (const Wall& wall : Room()) {
      const Eigen::Vector2d edge = wall.to - wall.from;
      const double t = std::clamp((in_room - wall.from).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
      nearest = std::min(nearest, (in_room - wall.from - t * edge).norm());
    }
    EXPECT_LT(nearest, 0.01);
  }
}

TEST(ScanLocation, WithoutScansThereAreNoPoints) {
  EXPECT_TRUE(PointsBehindDoor({}, {0, 0, 0}, {1, 0, 0}).empty());
  EXPECT_TRUE(RemoveHitsThroughDoors({}, {{0, 0, 0}}).empty());
}

TEST(ScanLocation, HitsThroughAnyOfTheDoorsAreRemoved) {
  const Pose2 robot{4.0, 3.0, 0.0};
  const PlacedScan whole = ScanIn(Room(), robot);
  const auto removed = [&](const std::vector<Pose2>& doors) {
    const std::vector<PlacedScan> cut = RemoveHitsThroughDoors({whole}, doors);
    EXPECT_EQ(cut.size(), 1U);
    return std::count_if(cut[0].scan.ranges.begin(), cut[0].scan.ranges.end(), [](float r) { return std::isnan(r); });
  };
  const Pose2 east{6.0, 3.0, 0.0};
  const Pose2 west{1.0, 3.0, 0.0};
  EXPECT_EQ(removed({}), 0);
  EXPECT_GT(removed({east}), 20);
  EXPECT_GT(removed({west}), 10);
  EXPECT_EQ(removed({east, west}), removed({east}) + removed({west}));
  EXPECT_EQ(removed({{20.0, 3.0, 0.0}}), 0) << "no beam reaches so far";
}

}  // namespace
}  // namespace enfilade::closure
