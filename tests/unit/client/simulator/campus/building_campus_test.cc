// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/building_campus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>

#include "client/simulator/campus/floor_areas.h"
#include "client/simulator/campus/wall_gaps.h"
#include "client/simulator/route_driver.h"
#include "client/simulator/simulation_files.h"
#include "client/simulator/world/world.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::simulator {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

double SizeOf(const std::vector<Eigen::Vector2d>& outline) {
  double twice = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& a = outline[i];
    const Eigen::Vector2d& b = outline[(i + 1) % outline.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return twice / 2.0;
}

void AddRectangle(double x, double y, double width, double height, std::vector<Barrier>& barriers) {
  const std::vector<Eigen::Vector2d> outline = RectangleOutline(x, y, width, height);
  for (std::size_t i = 0; i < 4; ++i) barriers.emplace_back(outline[i], outline[(i + 1) % 4]);
}

TEST(DivideFloor, FindsThePiecesButNotTheOutside) {
  std::vector<Barrier> barriers;
  AddRectangle(0.0, 0.0, 10.0, 6.0, barriers);
  barriers.emplace_back(Eigen::Vector2d(4.0, 0.0), Eigen::Vector2d(4.0, 6.0));
  AddRectangle(6.0, 2.0, 2.0, 2.0, barriers);  // a room within a room
  AddRectangle(0.0, 0.0, 1.0, 1.0, barriers);  // too small
  const std::vector<FloorArea> areas = DivideFloor(barriers, 2.0);
  ASSERT_THAT(areas, SizeIs(3));
  EXPECT_NEAR(areas[0].size, 32.0, 3.0);
  EXPECT_NEAR(SizeOf(areas[0].outline), 36.0, 2.0) << "counter-clockwise, with the room inside";
  EXPECT_NEAR(SizeOf(areas[1].outline), 23.0, 2.0);
  EXPECT_NEAR(SizeOf(areas[2].outline), 4.0, 0.8);
  for (const FloorArea& area : areas) EXPECT_TRUE(simulator::Contains(area.outline, area.inside));
  EXPECT_THAT(DivideFloor({}, 2.0), SizeIs(0));
  EXPECT_THAT(DivideFloor({{{0.0, 0.0}, {5.0, 0.0}}}, 2.0), SizeIs(0)) << "one wall encloses nothing";
}

TEST(GapsBetween, AreAsWideAsDoorsAndInLineWithAWall) {
  const auto wall = [](double ax, double ay, double bx, double by) {
    return Barrier(Eigen::Vector2d(ax, ay), Eigen::Vector2d(bx, by));
  };
  // Two walls in line, and one that ends before another one's side.
  const std::vector<Barrier> line = {wall(0, 0, 4, 0), wall(5.2, 0.05, 9, 0), wall(2, 5, 2, 1)};
  const std::vector<Barrier> gaps = GapsBetween(line, {});
  ASSERT_THAT(gaps, SizeIs(2));
  EXPECT_NEAR((gaps[0].second - gaps[0].first).norm(), 1.2, 1e-9);
  EXPECT_NEAR(gaps[1].second.y(), 0.0, 1e-9);
  EXPECT_THAT(GapsBetween(line, {wall(4, 0, 5.2, 0)}), SizeIs(1)) << "the first one has a door";
  EXPECT_THAT(GapsBetween({wall(0, 0, 4, 0), wall(4.3, 0, 9, 0)}, {}), SizeIs(0)) << "too narrow";
  EXPECT_THAT(GapsBetween({wall(0, 0, 4, 0), wall(6, 0, 9, 0)}, {}), SizeIs(0)) << "too wide";
  EXPECT_THAT(GapsBetween({wall(0, 0, 4, 0), wall(4, 0, 4, 3), wall(5, 0, 9, 0)}, {}), SizeIs(1))
      << "a corner is no free end, but the other wall has one";
}

// Two levels of 10 m x 6 m: a wall with a door divides the lower one, a lift stands in the upper right corner, and a
// door leads outside. The upper drawing is shifted by 100 pixels. One pixel is 0.1 m.
constexpr char kTwoFloors[] = R"(
name: house
levels:
  G:
    elevation: 0
    doors: [[4, 5, {name: [1, inner]}], [6, 7, {name: [1, outer]}]]
    fiducials: [[0, 0, a], [100, 0, b]]
    measurements: [[0, 1, {distance: [3, 10]}]]
    vertices: [[0, 0], [100, 0], [100, 60], [0, 60], [40, 20], [40, 30], [0, 30], [0, 40], [40, 0], [40, 60]]
    walls: [[0, 1, {}], [1, 2, {}], [2, 3, {}], [3, 0, {}], [8, 4, {}], [5, 9, {}]]
  F:
    elevation: 3
    fiducials: [[100, 0, a], [200, 0, b]]
    measurements: [[0, 1, {distance: [3, 10]}]]
    vertices: [[100, 0], [200, 0], [200, 60], [100, 60]]
    walls: [[0, 1, {}], [1, 2, {}], [2, 3, {}], [3, 0, {}]]
lifts:
  lift: {reference_floor_name: G, x: 85, y: 15, yaw: 0, width: 2, depth: 2,
         doors: {d: {width: 1.2, x: 0, y: -1.1, motion_axis_orientation: 0}}, level_doors: {G: [d], F: [d]}}
)";

// The areas through which the robot drives in one round, in order.
std::vector<std::string> DriveAll(const Campus& campus, const Robot& robot) {
  const auto world = std::make_shared<const World>(campus);
  RouteDriver driver(world, robot, {}, 0.05);
  std::vector<std::string> areas;
  while (true) {
    const auto step = driver.Next();
    EXPECT_OK(step);
    if (!step.ok() || !*step) return areas;
    const Area* here = campus.AreaAt(driver.level(), driver.T_campus_robot().translation());
    if (here && (areas.empty() || areas.back() != here->id)) areas.push_back(here->id);
  }
}

TEST(CampusOfBuilding, HasItsRoomsDoorsAndLifts) {
  ASSERT_OK_AND_ASSIGN(const prior::Building building, prior::ParseBuilding(kTwoFloors));
  ASSERT_OK_AND_ASSIGN(const Campus campus, CampusOf(building));
  ASSERT_THAT(campus.areas, SizeIs(5)) << "two rooms, the upper floor, the cabin on both";
  ASSERT_NE(campus.FindDoor("inner"), nullptr);
  EXPECT_EQ(campus.FindDoor("inner")->state, DoorState::kOpen);
  EXPECT_NEAR(campus.FindDoor("inner")->width(), 1.0, 1e-9);
  EXPECT_EQ(campus.FindDoor("outer")->state, DoorState::kClosed) << "there is no area outside";
  ASSERT_THAT(campus.lifts, SizeIs(1));
  // The upper level lies above the lower one.
  EXPECT_EQ(campus.AreaAt("F", {8.5, -1.5})->id, "lift");
  EXPECT_EQ(campus.AreaAt("G", {8.5, -1.5})->id, "lift");
  EXPECT_EQ(campus.AreaAt("F", {1.0, -1.0})->id, "F-1");
  EXPECT_EQ(campus.AreaAt("F", {11.0, -1.0}), nullptr);
}

TEST(CampusOfBuilding, IsToured) {
  ASSERT_OK_AND_ASSIGN(const prior::Building building, prior::ParseBuilding(kTwoFloors));
  ASSERT_OK_AND_ASSIGN(const Campus campus, CampusOf(building));
  ASSERT_THAT(campus.robots, SizeIs(2));
  std::set<std::string> begins;
  for (const Robot& robot : campus.robots) {
    const std::vector<std::string> areas = DriveAll(campus, robot);
    for (const std::string area : {"G-1", "G-2", "lift", "F-1"}) EXPECT_THAT(areas, ::testing::Contains(area));
    EXPECT_EQ(areas.front(), areas.back());
    begins.insert(areas.front());
  }
  EXPECT_THAT(begins, SizeIs(1));
}

TEST(CampusOfBuilding, NeedsAreas) {
  prior::Building building;
  building.name = "plain";
  building.levels.push_back({"L", 0, {}, {}, {{{0.0, 0.0}, {5.0, 0.0}}}});
  EXPECT_STATUS(CampusOf(building), absl::StatusCode::kInvalidArgument, HasSubstr("enclose no areas"));
  building.levels[0].walls.push_back({{0.0, 0.0}, {500.0, 0.0}});
  EXPECT_STATUS(CampusOf(building), absl::StatusCode::kInvalidArgument, HasSubstr("larger than 200 m"));
}

class RecordedBuildings : public ::testing::TestWithParam<const char*> {};

TEST_P(RecordedBuildings, AreTouredWithoutRunningIntoWalls) {
  ENFILADE_RECORDING_OR_SKIP(file, std::string("maps/rmf_demos/") + GetParam() + ".building.yaml");
  ASSERT_OK_AND_ASSIGN(const Campus campus, LoadCampus(file.string()));
  for (const Robot& robot : campus.robots) {
    const std::vector<std::string> visited = DriveAll(campus, robot);
    const std::set<std::string> areas(visited.begin(), visited.end());
    EXPECT_GE(robot.route.size(), 3U);
    EXPECT_GE(areas.size(), std::string(GetParam()) == "triple_H" ? 1U : 4U);
  }
}

// What the robot's route names: lifts and the levels that it takes them to.
std::vector<std::string> RidesOf(const Robot& robot) {
  std::vector<std::string> rides;
  for (const RouteStep& step : robot.route) {
    if (step.kind == RouteStep::Kind::kLift) rides.push_back(step.name + " " + step.level);
  }
  return rides;
}

TEST(CampusOfBuilding, TheSecondRobotTakesTheLevelsTheOtherWayRoundByAnotherLift) {
  ENFILADE_RECORDING_OR_SKIP(file, "maps/rmf_demos/hotel.building.yaml");
  ASSERT_OK_AND_ASSIGN(const Campus campus, LoadCampus(file.string()));
  ASSERT_THAT(campus.robots, SizeIs(2));
  EXPECT_THAT(RidesOf(campus.robots[0]), ::testing::ElementsAre("Lift1 L2", "Lift1 L3", "Lift1 L1"));
  EXPECT_THAT(RidesOf(campus.robots[1]), ::testing::ElementsAre("Lift2 L3", "Lift2 L2", "Lift2 L1"));
}

INSTANTIATE_TEST_SUITE_P(Demos, RecordedBuildings, ::testing::Values("hotel", "office", "triple_H"));

}  // namespace
}  // namespace enfilade::simulator
