// SPDX-License-Identifier: Apache-2.0
#include "perception/plan/read_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>

#include "core/prior/formats/building_plan.h"
#include "core/prior/formats/geojson_plan.h"
#include "core/prior/formats/svg_plan.h"
#include "core/prior/plan/planar.h"
#include "fmt/format.h"
#include "io/file.h"
#include "tests/support/plans/drawn_plan.h"
#include "tests/support/plans/plan_scores.h"
#include "tests/support/test_data.h"

namespace enfilade::perception {
namespace {

using ::enfilade::testing::DrawnPlan;
using ::enfilade::testing::DrawnPlanOptions;
using ::enfilade::testing::WallStyle;
using ::testing::HasSubstr;

struct PlanCase {
  std::string name;
  DrawnPlanOptions options;
};

std::vector<PlanCase> PlanCases() {
  std::vector<PlanCase> cases;
  for (const double turn : {0.0, 10.0, 27.0, 45.0}) {
    cases.push_back({fmt::format("Filled{:.0f}", turn), {.turn_deg = turn}});
    cases.push_back(
        {fmt::format("FilledFurnished{:.0f}", turn), {.turn_deg = turn, .line_px = 1.2, .furniture = true}});
  }
  for (const double turn : {0.0, 15.0, 35.0}) {
    cases.push_back({fmt::format("Double{:.0f}", turn), {.style = WallStyle::kDoubleLine, .turn_deg = turn}});
    cases.push_back({fmt::format("DoubleFurnished{:.0f}", turn),
                     {.style = WallStyle::kDoubleLine, .turn_deg = turn, .furniture = true}});
  }
  for (const double turn : {0.0, 20.0}) {
    cases.push_back(
        {fmt::format("FilledDimensions{:.0f}", turn), {.turn_deg = turn, .line_px = 1.5, .dimensions = true}});
    cases.push_back({fmt::format("FilledPlot{:.0f}", turn), {.turn_deg = turn, .plot = true}});
    cases.push_back({fmt::format("DoublePlotDimensions{:.0f}", turn),
                     {.style = WallStyle::kDoubleLine, .turn_deg = turn, .dimensions = true, .plot = true}});
  }
  cases.push_back({"Shaded", {.turn_deg = 5, .shade_at_edge = 0.45}});
  cases.push_back({"BrightLines", {.turn_deg = 5, .bright_lines = true}});
  return cases;
}

class DrawnPlanTest : public ::testing::TestWithParam<PlanCase> {};

TEST_P(DrawnPlanTest, IsReadAsItWasDrawn) {
  const DrawnPlan drawn = enfilade::testing::DrawPlan(GetParam().options);
  const auto plan = DecodePlan(drawn.png);
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_TRUE(prior::IsPlanar(plan->graph));
  const auto tolerance = enfilade::testing::InUnits({}, *drawn.truth.metres_per_unit);
  const auto walls = enfilade::testing::ScoreWalls(plan->graph, drawn.truth, tolerance);
  EXPECT_GE(walls.recall, 0.97);
  EXPECT_GE(walls.precision, 0.97);
  const auto corners = enfilade::testing::ScoreCorners(plan->graph, drawn.truth, tolerance);
  EXPECT_GE(corners.recall, 0.95);
  EXPECT_GE(corners.precision, 0.9);
  EXPECT_LE(corners.median_error, 1.0) << "px";
  const auto doors = enfilade::testing::ScoreDoors(plan->graph, drawn.truth, tolerance);
  EXPECT_GE(doors.recall, 0.85);
  EXPECT_GE(doors.precision, 0.85);
  EXPECT_GE(plan->graph.rooms.size(), 7u) << "seven rooms and the corridor; one door may be missed";
  EXPECT_LE(plan->graph.rooms.size(), 8u);
}

INSTANTIATE_TEST_SUITE_P(All, DrawnPlanTest, ::testing::ValuesIn(PlanCases()),
                         [](const auto& drawn) { return drawn.param.name; });

TEST(ReadPlan, GivesTheSamePlanAfterItWasWritten) {
  const enfilade::testing::TemporaryDirectory folder;
  const std::filesystem::path path = folder.path() / "plan_round_trip.geojson";
  const DrawnPlan drawn = enfilade::testing::DrawPlan();
  const auto plan = DecodePlan(drawn.png);
  ASSERT_TRUE(plan.ok()) << plan.status();
  ASSERT_TRUE(io::WriteFile(path, prior::WriteGeoJsonPlan(plan->graph)).ok());
  const auto again = ReadPlan(path);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(prior::WriteGeoJsonPlan(*again), prior::WriteGeoJsonPlan(plan->graph));
}

TEST(ReadPlan, GivesTheSameWallsInEveryFormatThatItIsWrittenIn) {
  const DrawnPlan drawn = enfilade::testing::DrawPlan({.turn_deg = 17});
  const PlanMeasure measure{.from = {0, 0}, .to = {25, 0}, .metres = 1};
  const auto plan = DecodePlan(drawn.png, {.measure = measure});
  ASSERT_TRUE(plan.ok()) << plan.status();
  const double metres = *plan->graph.metres_per_unit;
  const std::pair<std::string, ReadPlanOptions> files[] = {{prior::WriteGeoJsonPlan(plan->graph), {}},
                                                           {prior::WriteSvgPlan(plan->graph), {.measure = measure}},
                                                           {prior::WriteBuildingPlan(plan->graph, "L1", metres), {}}};
  for (const auto& [bytes, options] : files) {
    SCOPED_TRACE(bytes.substr(0, 20));
    const auto again = DecodePlan(bytes, options);
    ASSERT_TRUE(again.ok()) << again.status();
    EXPECT_NEAR(*again->graph.metres_per_unit, metres, 1e-9);
    ASSERT_EQ(again->graph.walls.size(), plan->graph.walls.size());
    EXPECT_EQ(again->graph.corners.size(), plan->graph.corners.size());
    EXPECT_EQ(again->graph.doors.size(), plan->graph.doors.size());
    // Each wall, to 1 mm at both ends.
    for (const prior::PlanWall& wall : plan->graph.walls) {
      const Eigen::Vector2d a = plan->graph.corners[wall.from].point, b = plan->graph.corners[wall.to].point;
      double nearest = std::numeric_limits<double>::infinity();
      for (const prior::PlanWall& other : again->graph.walls) {
        const Eigen::Vector2d c = again->graph.corners[other.from].point, d = again->graph.corners[other.to].point;
        nearest =
            std::min({nearest, std::max((a - c).norm(), (b - d).norm()), std::max((a - d).norm(), (b - c).norm())});
      }
      EXPECT_LE(nearest * metres, 0.001);
    }
  }
}

TEST(ReadPlan, HasAllDoorsAndLiftsOfTheHotelOfTheRmfDemos) {
  ENFILADE_RECORDING_OR_SKIP(path, "maps/rmf_demos/hotel.building.yaml");
  std::size_t doors = 0;
  for (const char* level : {"L1", "L2", "L3"}) {
    const auto plan = ReadPlan(path, {.level = level});
    ASSERT_TRUE(plan.ok()) << plan.status();
    EXPECT_EQ(plan->shafts.size(), 2u) << level;
    doors += plan->doors.size();
  }
  EXPECT_EQ(doors, 19u);
}

TEST(ReadPlan, TakesTheScaleFromAMeasuredLine) {
  const auto plan = DecodePlan(enfilade::testing::DrawPlan().png,
                               {.measure = PlanMeasure{.from = {10, 20}, .to = {40, 60}, .metres = 2}});
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_DOUBLE_EQ(*plan->graph.metres_per_unit, 0.04);
  const auto refused = DecodePlan(enfilade::testing::DrawPlan().png,
                                  {.measure = PlanMeasure{.from = {1, 2}, .to = {1, 2}, .metres = 2}});
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("measure"));
}

TEST(ReadPlan, NamesTheFileThatIsMissingOrNoPlan) {
  EXPECT_EQ(ReadPlan("/no/such/plan.png").status().code(), absl::StatusCode::kNotFound);
  const auto text = DecodePlan("This is no plan.");
  EXPECT_EQ(text.status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace enfilade::perception
