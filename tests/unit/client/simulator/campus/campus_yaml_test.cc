// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/campus/campus_yaml.h"

#include <gtest/gtest.h>

#include "client/simulator/campus/drawing.h"
#include "client/simulator/campus/shipped_campuses.h"
#include "tests/support/status_assertions.h"

namespace enfilade::simulator {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr const char* kTwoRooms = R"(
campus: two
areas:
  - {id: a, rect: [0, 0, 4, 3], doors: [{id: d, side: east, at: 1.5, width: 0.8}]}
  - {id: b, kind: outdoor, polygon: [[4, 0], [8, 0], [8, 3], [4, 3]]}
robots:
  - {id: r, route: [[1, 1], {door: d}, {wait: 2}]}
)";

TEST(CampusYaml, ReadsAreasDoorsAndRoutes) {
  ASSERT_OK_AND_ASSIGN(const Campus campus, ParseCampus(kTwoRooms));
  EXPECT_EQ(campus.name, "two");
  ASSERT_NE(campus.FindDoor("d"), nullptr);
  EXPECT_TRUE(campus.FindDoor("d")->a.isApprox(Eigen::Vector2d(4.0, 1.1)));
  EXPECT_TRUE(campus.FindDoor("d")->b.isApprox(Eigen::Vector2d(4.0, 1.9)));
  EXPECT_EQ(campus.AreaAt("ground", {2.0, 1.0})->id, "a");
  EXPECT_EQ(campus.AreaAt("ground", {5.0, 1.0})->id, "b");
  EXPECT_EQ(campus.AreaAt("ground", {9.0, 1.0}), nullptr);
  EXPECT_FALSE(campus.FindArea("b")->indoor());
  ASSERT_EQ(campus.robots[0].route.size(), 3U);
  EXPECT_EQ(campus.robots[0].route[1].name, "d");
}

TEST(CampusYaml, RefusesWhatItDoesNotKnowWithTheLine) {
  const auto refused = [](const std::string& yaml, const char* message) {
    EXPECT_STATUS(ParseCampus(yaml), absl::StatusCode::kInvalidArgument, HasSubstr(message));
  };
  refused("campus: [", "line");
  refused("- 1\n", "not a mapping");
  refused("campus: x\nareass: []\n", "line 2: the campus has no key \"areass\"");
  refused("areas:\n  - {id: a, rect: [0, 0, 4]}\n", "line 2: area.rect: expected 4 numbers");
  refused("areas:\n  - {id: a, rect: [0, 0, -4, 1]}\n", "must be positive");
  refused("areas:\n  - {id: a, rect: [0, 0, 4, x]}\n", "expected 4 numbers");
  refused("areas: [{id: a, rect: [0, 0, 4, 4]}, {id: a, rect: [4, 0, 4, 4]}]", "two areas \"a\"");
  refused("areas: [{id: a, rect: [0, 0, 4, 4], level: roof}]", "no level \"roof\"");
  refused("areas: [{id: a, rect: [0, 0, 4, 4], doors: [{id: d, side: up}]}]", "expected south, east, north, west");
  refused("areas: [{id: a, rect: [0, 0, 4, 4], doors: [{id: d, at: 3.9}]}]", "beyond its side");
  refused("robots: [{id: r, route: [{door: d}, [1, 1]]}]", "begins with a point");
  refused("robots: [{id: r, route: [[1, 1], {door: d}]}]", "no door \"d\"");
  refused("robots: [{id: Not an id, route: [[1, 1], [2, 2]]}]", "an id has");
  refused("drawings: [{rows: 'a a'}]", "two points 'a'");
}

TEST(CampusYaml, NamesTheShippedCampuses) {
  EXPECT_THAT(ShippedCampusNames(), Contains("figure1"));
  EXPECT_THAT(ShippedCampusNames(), Contains("lookalike"));
  EXPECT_STATUS(ShippedCampus("nowhere"), absl::StatusCode::kNotFound, HasSubstr("figure1"));
}

TEST(Drawing, HasItsOriginAtTheLowerLeft) {
  ASSERT_OK_AND_ASSIGN(const Drawing drawing, ParseDrawing("#####\n#a b#\n#   #\n#####\n", 0.5, {10.0, 20.0}));
  EXPECT_TRUE(drawing.points.at("a").isApprox(Eigen::Vector2d(10.75, 21.25)));
  EXPECT_TRUE(drawing.points.at("b").isApprox(Eigen::Vector2d(11.75, 21.25)));
  EXPECT_EQ(drawing.walls.size(), 8U) << "four sheets inside, four outside";
}

}  // namespace
}  // namespace enfilade::simulator
