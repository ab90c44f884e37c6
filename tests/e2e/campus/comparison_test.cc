// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/comparison.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/e2e/campus/campus_run.h"

namespace enfilade::testing {
namespace {

constexpr TimeNs kScan = 200'000'000;
constexpr double kStep = 0.12;  // m between scans

// A robot drives from room A (x < 0) through a door at x = 0 into room B and on through a door at x = 8 into room C.
// The world is the frame of its start: turned, and moved.
class ComparisonTest : public ::testing::Test {
 protected:
  ComparisonTest() {
    truth_.robot = "r";
    for (int i = 0; i <= 150; ++i) {
      const double x = -5.0 + kStep * i;
      const std::string area = x < 0.0 ? "A" : x < 8.0 ? "B" : "C";
      truth_.poses.push_back({kScan * i, {x, 0.0, 0.3}, "ground", area});
    }
    Pass("d1", 0.0, "A", "B");
    Pass("d2", 8.0, "B", "C");
    // Each session goes on 2 m behind its door.
    Map("mA", -5.0, 2.0);
    Map("mB", 2.0, 10.0);
    Map("mC", 10.0, 14.0);
    Join("l1", {"mA", "mB"}, 0.3, 0.2);
    Join("l2", {"mB", "mC"}, 8.2, 0.0);
  }

  void Pass(const std::string& door, double x, const std::string& from, const std::string& to) {
    truth_.passages.push_back(
        {static_cast<TimeNs>((x + 5.0) / kStep * static_cast<double>(kScan)), {x, 0.0, 0.3}, "ground", door, from, to});
    doors_.push_back({door, {x, -0.5}, {x, 0.5}});
  }
  // The scans between two places, in a map whose frame is somewhere.
  void Map(const std::string& map, double begin, double end) {
    state_.maps.push_back(map);
    Session(map, begin, end);
  }
  void Session(const std::string& map, double begin, double end, Pose2 T_world_shift = {}) {
    const Pose2 T_world_map{1.0, 2.0, -0.7};
    client::MappedStretch stretch{"s", map, map, T_world_map, {}};
    for (const TruePoint& point : truth_.poses) {
      if (point.T_campus_robot.x < begin || point.T_campus_robot.x >= end) continue;
      stretch.poses.push_back(
          {point.time, Inverse(T_world_map) * T_world_shift * Inverse(T_campus_world_) * point.T_campus_robot});
    }
    state_.stretches["r"].push_back(stretch);
  }
  void Join(const std::string& id, std::vector<std::string> maps, double x, double y) {
    const Pose2 world = Inverse(T_campus_world_) * Pose2{x, y, 0.0};
    state_.link_points.push_back({id, std::move(maps), true, Eigen::Vector2d(world.x, world.y)});
  }
  std::vector<client::MappedStretch>& stretches() { return state_.stretches["r"]; }
  Comparison Result() { return Compare({truth_}, doors_, state_); }

  const Pose2 T_campus_world_{-5.0, 0.0, 0.3};
  DriveTruth truth_;
  std::vector<TrueDoor> doors_;
  MappedState state_;
};

TEST_F(ComparisonTest, RightMapsAreExact) {
  const Comparison result = Result();
  EXPECT_TRUE(result.exact) << ::testing::PrintToString(result.wrong);
  EXPECT_EQ(result.areas, 3);
  EXPECT_EQ(result.maps, 3);
  EXPECT_EQ(result.doors, 2);
  EXPECT_EQ(result.joins, 2);
  EXPECT_EQ(result.components, 1);
  EXPECT_EQ(result.passages, 2);
  EXPECT_EQ(result.stretches, 3);
  EXPECT_LT(result.position_max, 1e-9);
  EXPECT_LT(result.unmapped_s, 0.5);
}

TEST_F(ComparisonTest, AGapBetweenTwoDoorsIsNoRoom) {
  truth_.poses[65].area = "gap";
  truth_.poses[66].area = "gap";
  Comparison result = Result();
  EXPECT_EQ(result.areas, 3);
  EXPECT_TRUE(result.exact) << ::testing::PrintToString(result.wrong);
  for (int i = 67; i < 80; ++i) truth_.poses[static_cast<std::size_t>(i)].area = "gap";  // stayed there
  result = Result();
  EXPECT_EQ(result.areas, 4);
  EXPECT_EQ(result.areas_missing, 1);
}

TEST_F(ComparisonTest, TwoRoomsInOneMap) {
  for (client::MappedStretch& stretch : stretches()) stretch.map = stretch.map == "mC" ? "mB" : stretch.map;
  state_.maps.pop_back();
  state_.link_points.pop_back();
  const Comparison result = Result();
  EXPECT_FALSE(result.exact);
  EXPECT_EQ(result.areas_missing, 1);
  EXPECT_EQ(result.maps_merged, 1);
  EXPECT_EQ(result.areas_doubled, 0);
  EXPECT_EQ(result.maps_extra, 0);
  EXPECT_EQ(result.doors_missing, 1);
  EXPECT_EQ(result.joins_false + result.joins_wrong, 0);
}

TEST_F(ComparisonTest, ARoomWithTwoMaps) {
  stretches().clear();
  Session("mA", -5.0, 2.0);
  Session("mB", 2.0, 5.0);
  Map("mX", 5.0, 10.0);
  Session("mC", 10.0, 14.0);
  Join("lx", {"mB", "mX"}, 5.0, 0.0);
  const Comparison result = Result();
  EXPECT_EQ(result.areas_doubled, 1);
  EXPECT_EQ(result.maps_extra, 1);
  EXPECT_EQ(result.areas_missing, 0);
  EXPECT_EQ(result.joins_false, 1) << "there is no door within the room";
  EXPECT_EQ(result.doors_missing, 0);
}

TEST_F(ComparisonTest, LinkPointsElsewhereOrOfOtherMaps) {
  state_.link_points[0].maps = {"mA", "mC"};
  Join("l3", {"mB", "mC"}, 7.9, 0.0);
  Join("l4", {"mB", "mC"}, 8.0, 3.0);
  state_.link_points.push_back({"candidate", {"mA"}, false, std::nullopt});
  const Comparison result = Result();
  EXPECT_EQ(result.joins, 4);
  EXPECT_EQ(result.joins_wrong, 1);
  EXPECT_EQ(result.doors_missing, 1);
  EXPECT_EQ(result.doors_doubled, 1);
  EXPECT_EQ(result.joins_false, 1);
  EXPECT_EQ(result.candidates, 1);
}

TEST_F(ComparisonTest, AMapThatIsElsewhereInTheWorld) {
  stretches().pop_back();
  Session("mC", 10.0, 14.0, {0.0, 1.2, 0.0});
  Comparison result = Result();
  EXPECT_FALSE(result.exact);
  EXPECT_EQ(result.false_placements, 1) << "the stretch behind d2";
  EXPECT_NEAR(result.position_max, 1.2, 1e-9);
  stretches().pop_back();
  Session("mC", 10.0, 14.0, {0.0, 0.8, 0.0});
  EXPECT_EQ(Result().false_placements, 0);
  stretches().pop_back();
  const Pose2 about = Inverse(T_campus_world_) * Pose2{12.0, 0.0, 0.0};
  Session("mC", 10.0, 14.0, Pose2{about.x, about.y, 0.2} * Inverse(Pose2{about.x, about.y, 0.0}));
  EXPECT_EQ(Result().false_placements, 1) << "turned by 11 degrees";
}

TEST_F(ComparisonTest, AGraphInPieces) {
  state_.link_points.pop_back();
  stretches().back().T_world_map.reset();
  const Comparison result = Result();
  EXPECT_EQ(result.components, 2);
  EXPECT_EQ(result.false_placements, 0);
  EXPECT_NEAR(result.unplaced_s, 0.2 * 3.0 / kStep, 0.6);
  EXPECT_FALSE(result.exact);
}

TEST_F(ComparisonTest, ARoomThatWasNeverMapped) {
  stretches().pop_back();
  const Comparison result = Result();
  EXPECT_EQ(result.areas_missing, 1);
  EXPECT_EQ(result.maps_extra, 1) << "a map in which nobody is";
  EXPECT_GT(result.unmapped_s, 5.0);
}

TEST(CampusName, IsAFilesNameWithoutItsEnding) {
  EXPECT_EQ(CampusNameOf("random:7"), "random:7");
  EXPECT_EQ(CampusNameOf("/data/mine.yaml"), "mine");
  EXPECT_EQ(CampusNameOf("maps/hotel.building.yaml"), "hotel");
}

TEST(SiteId, HasOnlyWhatAnIdMayHave) {
  EXPECT_EQ(SiteIdOf("random:9001-1"), "random-9001-1");
  EXPECT_EQ(SiteIdOf("../My Campus_2-7"), "my-campus-2-7");
  EXPECT_EQ(SiteIdOf(std::string(80, 'a') + "-1").size(), 63U);
}

}  // namespace
}  // namespace enfilade::testing
