// SPDX-License-Identifier: Apache-2.0
#include "core/prior/formats/building_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Two levels of 10 x 5 m, drawn at 0.1 and 0.05 m per pixel; the upper drawing is shifted.
constexpr char kTwoLevels[] = R"(
name: house
levels:
  Upper:
    elevation: 4
    fiducials: [[100, 100, a], [300, 100, b]]
    measurements: [[0, 1, {distance: [3, 10]}]]
    vertices: [[100, 100, 0, ""], [300, 100, 0, ""], [300, 200, 0, ""], [100, 200, 0, ""]]
    walls: [[0, 1, {}], [1, 2, {}], [2, 3, {}], [3, 0, {}]]
  Ground:
    elevation: 0
    doors: [[1, 2, {name: [1, "Door 'A'"], type: [1, hinged]}]]
    fiducials: [[0, 0, a], [100, 0, b]]
    floors: [{parameters: {}, vertices: [0, 1, 2, 3]}]
    measurements: [[0, 1, {distance: [3, 10]}]]
    vertices: [[0, 0, 0, ""], [100, 0, 0, ""], [100, 50, 0, ""], [0, 50, 0, ""]]
  Roof:
    elevation: 8
    vertices: [[0, 0, 0, ""]]
lifts:
  Lift:
    reference_floor_name: Ground
    x: 50
    y: 20
    yaw: 0.5
    level_doors: {Ground: [d], Upper: [d], Roof: [d]}
  Nowhere:
    reference_floor_name: Cellar
    x: 0
    y: 0
    level_doors: {Ground: [d]}
)";

TEST(BuildingFileTest, ReadsLevelsDoorsAndLiftsInMetres) {
  ASSERT_OK_AND_ASSIGN(const prior::Building building, prior::ParseBuilding(kTwoLevels));
  EXPECT_EQ(building.name, "house");
  ASSERT_THAT(building.levels, SizeIs(2));
  const prior::BuildingLevel& ground = building.levels[0];
  EXPECT_EQ(ground.name, "Ground");
  EXPECT_EQ(ground.level, 0);
  ASSERT_THAT(ground.outline, SizeIs(4));
  double left = 0, right = 0, bottom = 0;
  for (const Eigen::Vector2d& corner : ground.outline) {
    left = std::min(left, corner.x());
    right = std::max(right, corner.x());
    bottom = std::min(bottom, corner.y());
  }
  EXPECT_NEAR(left, 0.0, 1e-12);
  EXPECT_NEAR(right, 10.0, 1e-12);
  EXPECT_NEAR(bottom, -5.0, 1e-12);
  ASSERT_THAT(ground.doors, SizeIs(1));
  EXPECT_EQ(ground.doors[0].name, "Door 'A'");
  EXPECT_THAT(ground.doors[0].T_level_door, PoseNear(Pose2{10, -2.5, 0}, 1e-9, 1e-9));
  EXPECT_EQ(building.levels[1].level, 1);
  EXPECT_THAT(building.levels[1].outline, SizeIs(4));

  ASSERT_THAT(building.lifts, SizeIs(1));
  ASSERT_THAT(building.lifts[0].stops, SizeIs(2));
  EXPECT_THAT(building.lifts[0].stops[0].T_level_cabin, PoseNear(Pose2{5, -2, 0.5}, 1e-9, 1e-9));
  EXPECT_THAT(building.lifts[0].stops[1].T_level_cabin, PoseNear(Pose2{10, -7, 0.5}, 1e-9, 1e-9));
}

TEST(BuildingFileTest, RemarksOnWhatItDidNotImport) {
  ASSERT_OK_AND_ASSIGN(const prior::Building building, prior::ParseBuilding(kTwoLevels));
  ASSERT_THAT(building.remarks, SizeIs(2));
  EXPECT_EQ(building.remarks[0].item, "levels Roof");
  EXPECT_TRUE(building.remarks[0].refused);
  EXPECT_EQ(building.remarks[1].item, "lifts Nowhere");
  EXPECT_THAT(building.remarks[1].why, HasSubstr("Cellar"));
  ASSERT_OK_AND_ASSIGN(const prior::Building broken, prior::ParseBuilding(R"(
levels:
  A:
    measurements: [[0, 1, {distance: [3, 10]}]]
    vertices: [[0, 0, 0, ""], [100, 0, 0, ""]]
    walls: [[0, 7, {}]]
  B:
    vertices: [nonsense]
)"));
  EXPECT_THAT(broken.levels, IsEmpty());
  ASSERT_THAT(broken.remarks, SizeIs(2));
  EXPECT_THAT(broken.remarks[0].why, HasSubstr("vertex"));
  EXPECT_CODE(prior::ParseBuilding("levels: [1, 2]"), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(prior::ParseBuilding("{"), absl::StatusCode::kInvalidArgument);
}

TEST(BuildingFileTest, ReadsTheHotelOfTheRmfDemos) {
  ENFILADE_RECORDING_OR_SKIP(path, "maps/rmf_demos/hotel.building.yaml");
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  ASSERT_OK_AND_ASSIGN(const prior::Building building, prior::ParseBuilding(text.str()));
  ASSERT_THAT(building.levels, SizeIs(3));
  EXPECT_THAT(building.lifts, SizeIs(2));
  for (const prior::BuildingLift& lift : building.lifts) EXPECT_THAT(lift.stops, SizeIs(3));
  for (const prior::BuildingLevel& level : building.levels) {
    EXPECT_GE(level.outline.size(), 3U);
    EXPECT_FALSE(level.doors.empty());
  }
}

struct RefusedPart {
  const char* name;
  const char* yaml;
  const char* item;
  const char* why;
};

class BuildingFileRefusals : public ::testing::TestWithParam<RefusedPart> {};

// A part that cannot be read gives a remark, and the sound level beside it is imported all the same.
TEST_P(BuildingFileRefusals, NameThePartAndSpareTheOthers) {
  const std::string sound = R"(
  Sound:
    elevation: 100
    measurements: [[0, 1, {distance: [3, 10]}]]
    vertices: [[0, 0, 0, ""], [100, 0, 0, ""], [100, 50, 0, ""]]
    floors: [{vertices: [0, 1, 2]}]
)";
  ASSERT_OK_AND_ASSIGN(const prior::Building building,
                       prior::ParseBuilding("levels:" + sound + std::string(GetParam().yaml)));
  EXPECT_EQ(std::count_if(building.levels.begin(), building.levels.end(),
                          [](const prior::BuildingLevel& level) { return level.name == "Sound"; }),
            1);
  ASSERT_THAT(building.remarks, SizeIs(1));
  EXPECT_EQ(building.remarks[0].item, GetParam().item);
  EXPECT_THAT(building.remarks[0].why, HasSubstr(GetParam().why));
}

#define LEVEL(members) "  Bad:\n    vertices: [[0, 0], [100, 0], [100, 50]]\n" members
#define MEASURED "    measurements: [[0, 1, {distance: [3, 10]}]]\n"
#define LIFT(members) "lifts:\n  Bad:\n" members

INSTANTIATE_TEST_SUITE_P(
    All, BuildingFileRefusals,
    ::testing::Values(
        RefusedPart{"NoScale", LEVEL("    walls: [[0, 1]]\n"), "levels Bad", "scale is unknown"},
        RefusedPart{"MeasuredNothing", LEVEL("    measurements: [[0, 0, {distance: [3, 10]}]]\n"), "levels Bad",
                    "scale is unknown"},
        RefusedPart{"MeasuredBackwards", LEVEL("    measurements: [[0, 1, {distance: [3, -10]}]]\n"), "levels Bad",
                    "scale is unknown"},
        RefusedPart{"MeasuredBeyondTheVertices", LEVEL("    measurements: [[0, 9, {distance: [3, 10]}]]\n"),
                    "levels Bad", "scale is unknown"},
        RefusedPart{"FloorBeyondTheVertices", LEVEL(MEASURED "    floors: [{vertices: [0, 1, 7]}]\n"), "levels Bad",
                    "a vertex that does not exist"},
        RefusedPart{"DoorBeyondTheVertices",
                    LEVEL(MEASURED "    floors: [{vertices: [0, 1, 2]}]\n    doors: [[0, 8, {name: [1, d]}]]\n"),
                    "levels Bad", "a vertex that does not exist"},
        RefusedPart{"VertexOfWords", "  Bad:\n    vertices: [[a, b]]\n" MEASURED, "levels Bad",
                    "traffic editor's format"},
        RefusedPart{"VertexAtInfinity", "  Bad:\n    vertices: [[0, 0], [100, 0], [.inf, 3]]\n" MEASURED, "levels Bad",
                    "a vertex that is not finite"},
        RefusedPart{"VertexThatIsNoNumber", "  Bad:\n    vertices: [[0, 0], [100, 0], [3, .nan]]\n" MEASURED,
                    "levels Bad", "a vertex that is not finite"},
        RefusedPart{"WallBeyondAllNumbers",
                    "  Bad:\n    vertices: [[0, 0], [1, 0], [1e300, 1]]\n"
                    "    measurements: [[0, 1, {distance: [3, 1e300]}]]\n    walls: [[0, 2]]\n",
                    "levels Bad", "a wall that is not finite in metres"},
        RefusedPart{"ElevationOfWords", LEVEL(MEASURED "    elevation: high\n"), "levels Bad",
                    "traffic editor's format"},
        RefusedPart{"NegativeIndex", LEVEL(MEASURED "    walls: [[0, -1]]\n"), "levels Bad", "traffic editor's format"},
        RefusedPart{"NoOutline", LEVEL(MEASURED), "levels Bad", "neither floors nor walls"},
        RefusedPart{"WallsOnOneLine", LEVEL(MEASURED "    walls: [[0, 1], [1, 0]]\n"), "levels Bad", "no outline"},
        RefusedPart{"LiftWithoutReference", LIFT("    x: 1\n    y: 1\n"), "lifts Bad", "traffic editor's format"},
        RefusedPart{"LiftOnAnUnknownFloor", LIFT("    reference_floor_name: Attic\n    x: 1\n    y: 1\n"), "lifts Bad",
                    "its reference floor \"Attic\" was not imported"},
        RefusedPart{"LiftWithoutPlace", LIFT("    reference_floor_name: Sound\n    y: 1\n"), "lifts Bad",
                    "traffic editor's format"},
        RefusedPart{"LiftWithoutDoors", LIFT("    reference_floor_name: Sound\n    x: 1\n    y: 1\n"), "lifts Bad",
                    "does not stop at any imported level"}),
    [](const auto& param) { return param.param.name; });

TEST(BuildingFileTest, CountsLevelsFromTheGround) {
  const auto level = [](const char* name, double elevation) {
    return std::string("  ") + name + ":\n    elevation: " + std::to_string(elevation) +
           "\n    vertices: [[0, 0], [100, 0], [100, 50]]\n    measurements: [[0, 1, {distance: [3, 10]}]]\n"
           "    floors: [{vertices: [0, 1, 2]}]\n";
  };
  ASSERT_OK_AND_ASSIGN(const prior::Building building,
                       prior::ParseBuilding("levels:\n" + level("Top", 8.0) + level("Cellar", -4.0) +
                                            level("Ground", -0.2) + level("Deep", -8.0)));
  ASSERT_THAT(building.levels, SizeIs(4));
  const std::pair<const char*, int> expected[] = {{"Deep", -2}, {"Cellar", -1}, {"Ground", 0}, {"Top", 1}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(building.levels[i].name, expected[i].first);
    EXPECT_EQ(building.levels[i].level, expected[i].second);
  }
}

TEST(BuildingFileTest, TakesMetresAndUpwardYFromCartesianBuildings) {
  ASSERT_OK_AND_ASSIGN(const prior::Building building, prior::ParseBuilding(R"(
coordinate_system: cartesian_meters
levels:
  L1:
    vertices: [[0, 0], [4, 0], [4, 3], [0, 3]]
    floors: [{vertices: [0, 1, 2, 3]}]
    doors: [[1, 2, {name: [1, east]}]]
)"));
  ASSERT_THAT(building.levels, SizeIs(1));
  EXPECT_THAT(building.remarks, IsEmpty());
  EXPECT_THAT(building.levels[0].doors.at(0).T_level_door, PoseNear(Pose2{4.0, 1.5, -M_PI}, 1e-9, 1e-9));
  double top = 0.0;
  for (const Eigen::Vector2d& corner : building.levels[0].outline) top = std::max(top, corner.y());
  EXPECT_NEAR(top, 3.0, 1e-12);
}

}  // namespace
}  // namespace enfilade::testing
