// SPDX-License-Identifier: Apache-2.0
#include "core/prior/formats/geojson_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "fmt/format.h"

namespace enfilade::prior {
namespace {

using testing::HasSubstr;

PlanGraph Lab() {
  PlanGraph plan;
  plan.corners = {{{0.1, 0}}, {{40, 1.0 / 3}}, {{40, 30}}, {{-1e-7, 30}}};
  plan.walls = {{.from = 0, .to = 1, .thickness = 1.25, .confidence = 0.8}, {.from = 1, .to = 2}, {.from = 3, .to = 2}};
  plan.doors = {{.from = {10, 0}, .to = {18, 0}, .confidence = 0.6}};
  plan.rooms = {{.outline = {{0, 0}, {40, 0}, {40, 30}, {0, 30}}, .name = "Halle \"1\""}};
  plan.shafts = {{.kind = ShaftKind::kStairs, .outline = {{1, 1}, {2, 1}, {2, 2}}, .name = "S"}};
  plan.metres_per_unit = 0.0123456789;
  return plan;
}

TEST(GeoJsonPlan, IsReadAsItWasWritten) {
  const auto read = ReadGeoJsonPlan(WriteGeoJsonPlan(Lab()));
  ASSERT_TRUE(read.ok()) << read.status();
  const PlanGraph plan = Lab();
  ASSERT_EQ(read->corners.size(), plan.corners.size());
  for (std::size_t i = 0; i < plan.corners.size(); ++i) EXPECT_EQ(read->corners[i].point, plan.corners[i].point);
  ASSERT_EQ(read->walls.size(), plan.walls.size());
  for (std::size_t i = 0; i < plan.walls.size(); ++i) {
    EXPECT_EQ(read->walls[i].from, plan.walls[i].from);
    EXPECT_EQ(read->walls[i].to, plan.walls[i].to);
    EXPECT_EQ(read->walls[i].thickness, plan.walls[i].thickness);
    EXPECT_EQ(read->walls[i].confidence, plan.walls[i].confidence);
  }
  ASSERT_EQ(read->doors.size(), 1u);
  EXPECT_EQ(read->doors[0].to, plan.doors[0].to);
  EXPECT_EQ(read->doors[0].confidence, 0.6);
  ASSERT_EQ(read->rooms.size(), 1u);
  EXPECT_EQ(read->rooms[0].outline, plan.rooms[0].outline);
  EXPECT_EQ(read->rooms[0].name, plan.rooms[0].name);
  ASSERT_EQ(read->shafts.size(), 1u);
  EXPECT_EQ(read->shafts[0].kind, ShaftKind::kStairs);
  EXPECT_EQ(read->shafts[0].outline, plan.shafts[0].outline);
  EXPECT_EQ(read->metres_per_unit, plan.metres_per_unit);
}

std::string Document(const std::string& members, const std::string& type, const std::string& coordinates) {
  return fmt::format(
      R"({{"type":"FeatureCollection",{}"features":[{{"type":"Feature","properties":{{}},"geometry":{{"type":"{}","coordinates":{}}}}}]}})",
      members, type, coordinates);
}

TEST(GeoJsonPlan, TurnsMetresOverAndTakesPolygonsAsWalls) {
  const auto plan = ReadGeoJsonPlan(Document(R"("frame":"metres",)", "Polygon", "[[[0,0],[4,0],[4,3],[0,3],[0,0]]]"));
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_EQ(plan->walls.size(), 4u);
  EXPECT_EQ(plan->corners[4].point, Eigen::Vector2d(4, -3));
  EXPECT_EQ(plan->metres_per_unit, 1.0);
}

TEST(GeoJsonPlan, ProjectsLongitudeAndLatitude) {
  const auto plan = ReadGeoJsonPlan(Document("", "LineString", "[[11.5,48.1],[11.5,48.1009]]"));
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_NEAR(WallLength(*plan), 100.08, 0.05);  // 1.8 arc minutes of the meridian at 48 degrees
  EXPECT_LT(plan->corners[1].point.y(), plan->corners[0].point.y()) << "north is up in the sheet";
}

// A person has moved a wall, drawn another, and saved all by a program that writes null where there is no value, loses
// members that it does not know, and has dropped a corner.
TEST(GeoJsonPlan, ReadsWhatWasEdited) {
  const std::string wall =
      R"({{"type":"Feature","properties":{{"kind":{},"from":{},"to":{},"thickness":{},"confidence":null,"name":null}},
          "geometry":{{"type":"LineString","coordinates":{}}}}})";
  const std::string corner =
      R"({{"type":"Feature","properties":{{"kind":"corner","from":null}},"geometry":{{"type":"Point","coordinates":{}}}}})";
  const std::string text =
      "{\"type\":\"FeatureCollection\",\"name\":\"plan\",\"features\":[" + fmt::format(fmt::runtime(corner), "[0,0]") +
      "," + fmt::format(fmt::runtime(corner), "[400,0]") + "," +
      fmt::format(fmt::runtime(wall), "\"wall\"", 0, 1, 1.25, "[[0,0],[400,0]]") + "," +
      fmt::format(fmt::runtime(wall), "\"wall\"", 1, 2, 2, "[[400,0],[400,300]]") + "," +
      fmt::format(fmt::runtime(wall), "null", "null", "null", "null", "[[400,300],[0,300],[0,0]]") + "," +
      fmt::format(fmt::runtime(wall), "\"wall\"", 0, 1, 3, "[[0,0],[410,0]]") + "]}";
  const auto plan = ReadEditedPlan(text);
  ASSERT_TRUE(plan.ok()) << plan.status();
  ASSERT_EQ(plan->walls.size(), 5u);
  EXPECT_EQ(plan->walls[0].to, 1);
  EXPECT_EQ(plan->walls[0].thickness, 1.25);
  const auto ends = [&](std::size_t i) {
    return std::pair{plan->corners[static_cast<std::size_t>(plan->walls[i].from)].point,
                     plan->corners[static_cast<std::size_t>(plan->walls[i].to)].point};
  };
  EXPECT_EQ(ends(1), (std::pair<Eigen::Vector2d, Eigen::Vector2d>{{400, 0}, {400, 300}}));
  EXPECT_EQ(plan->walls[1].thickness, 2);
  EXPECT_EQ(ends(3), (std::pair<Eigen::Vector2d, Eigen::Vector2d>{{0, 300}, {0, 0}}));
  EXPECT_EQ(plan->walls[3].thickness, 0);
  EXPECT_EQ(plan->walls[3].confidence, 1);
  EXPECT_EQ(ends(4), (std::pair<Eigen::Vector2d, Eigen::Vector2d>{{0, 0}, {410, 0}})) << "its line was moved";
  EXPECT_FALSE(plan->metres_per_unit.has_value());
  EXPECT_FALSE(ReadGeoJsonPlan(text).ok()) << "nobody has said that it is in the sheet frame";
  EXPECT_THAT(
      std::string(ReadEditedPlan(Document(R"("frame":"metres",)", "LineString", "[[1,2],[3,4]]")).status().message()),
      HasSubstr("expected sheet"));
}

struct Fault {
  const char* name;
  std::string text;
  const char* message;
};

class FaultyGeoJson : public ::testing::TestWithParam<Fault> {};

TEST_P(FaultyGeoJson, IsRefused) {
  const auto plan = ReadGeoJsonPlan(GetParam().text);
  EXPECT_EQ(plan.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(plan.status().message()), HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    All, FaultyGeoJson,
    testing::Values(
        Fault{"NoJson", "{\"type\":", "not a GeoJSON plan"}, Fault{"NoCollection", "{}", "not a GeoJSON"},
        Fault{"NaN", Document("", "LineString", "[[11.5,NaN],[11.6,48]]"), "not a GeoJSON plan"},
        Fault{"NoNumber", Document("", "LineString", "[[\"a\",1],[2,3]]"), "feature 0: a position is not two numbers"},
        Fault{"Range", Document("", "LineString", "[[11,48],[200,48]]"), "longitude 200 and latitude 48"},
        Fault{"RangeOfLatitude", Document("", "Polygon", "[[[11,48],[12,48],[12,-90],[11,48]]]"), "latitude -90"},
        Fault{"Beyond", Document("", "LineString", "[[11,48],[12,1e400]]"), "not a GeoJSON plan"},
        Fault{"BeyondAnyDrawing", Document(R"("frame":"metres",)", "LineString", "[[11,48],[12,1e300]]"),
              "beyond 1e+12"},
        Fault{"Nested", Document("", "LineString", std::string(300'000, '[') + std::string(300'000, ']')), "feature 0"},
        Fault{"NestedMany",
              Document(R"("frame":"metres",)", "MultiPolygon", std::string(300'000, '[') + std::string(300'000, ']')),
              "feature 0"},
        Fault{"ThicknessOfWords",
              R"({"type":"FeatureCollection","frame":"sheet","features":[{},{"type":"Feature",
                "properties":{"thickness":"wide"},"geometry":{"type":"LineString","coordinates":[[0,0],[1,0]]}}]})",
              "feature 1: "},
        Fault{"NameOfNumbers",
              R"({"type":"FeatureCollection","frame":"sheet","features":[{"type":"Feature",
                "properties":{"name":7},"geometry":{"type":"Polygon","coordinates":[[[0,0],[1,0],[1,1],[0,0]]]}}]})",
              "feature 0: "},
        Fault{"Frame", Document(R"("frame":"feet",)", "LineString", "[[1,2],[3,4]]"), "frame is \"feet\""},
        Fault{"SelfCrossing", Document(R"("frame":"metres",)", "Polygon", "[[[0,0],[4,4],[4,0],[0,4],[0,0]]]"),
              "crosses itself"}),
    [](const auto& fault) { return std::string(fault.param.name); });

TEST(GeoJsonPlan, WhatIsNoNumberOfACornerLeavesTheLine) {
  for (const char* from : {"0.5", "-1", "1e300", "99999999999999999999", "7"}) {
    const auto plan = ReadGeoJsonPlan(fmt::format(
        R"({{"type":"FeatureCollection","frame":"sheet","features":[{{"type":"Feature","properties":{{"kind":"wall",
        "from":{},"to":1}},"geometry":{{"type":"LineString","coordinates":[[0,0],[3,4]]}}}}]}})",
        from));
    ASSERT_TRUE(plan.ok()) << plan.status();
    EXPECT_EQ(WallLength(*plan), 5);
  }
}

TEST(GeoJsonPlan, RefusesMoreThanAMillionWalls) {
  std::string positions = "[0,0]";
  for (int i = 0; i < 500'001; ++i) positions += ",[1,1],[0,0]";
  const auto plan = ReadGeoJsonPlan(Document(R"("frame":"metres",)", "LineString", "[" + positions + "]"));
  EXPECT_EQ(plan.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(plan.status().message()), HasSubstr("1000000 walls"));
}

}  // namespace
}  // namespace enfilade::prior
