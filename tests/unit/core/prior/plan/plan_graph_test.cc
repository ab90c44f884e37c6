// SPDX-License-Identifier: Apache-2.0
#include "core/prior/plan/plan_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

namespace enfilade::prior {
namespace {

PlanGraph Room() {
  PlanGraph plan;
  plan.corners = {{{0, 0}}, {{40, 0}}, {{40, 30}}, {{0, 30}}};
  plan.walls = {{.from = 0, .to = 1}, {.from = 1, .to = 2}, {.from = 2, .to = 3}, {.from = 3, .to = 0}};
  plan.doors = {{.from = {10, 0}, .to = {18, 0}}};
  plan.rooms = {{.outline = {{0, 0}, {40, 0}, {40, 30}, {0, 30}}, .name = "Hall"}};
  plan.metres_per_unit = 0.1;
  return plan;
}

TEST(PlanGraph, ThatIsLargerThanAnyBuildingIsRefused) {
  PlanGraph plan;
  plan.corners = {{{0, 0}}, {{30'000, 0}}};
  plan.walls = {{.from = 0, .to = 1}};
  EXPECT_TRUE(Validate(plan).ok()) << "its unit is unknown";
  plan.metres_per_unit = 1.0;
  EXPECT_EQ(Validate(plan).code(), absl::StatusCode::kInvalidArgument);
  plan.metres_per_unit = 0.001;
  EXPECT_TRUE(Validate(plan).ok());
  plan.corners[1].point.x() = 1e13;
  EXPECT_EQ(Validate(plan).code(), absl::StatusCode::kInvalidArgument);
}

TEST(PlanGraph, LengthsAreThoseOfTheCentreLines) {
  EXPECT_EQ(LengthOf(Room(), Room().walls[1]), 30);
  EXPECT_EQ(WallLength(Room()), 140);
  EXPECT_TRUE(Validate(Room()).ok());
}

struct Fault {
  const char* name;
  std::function<void(PlanGraph&)> make;
  const char* message;
};

class FaultyPlanGraph : public ::testing::TestWithParam<Fault> {};

TEST_P(FaultyPlanGraph, IsRefusedByName) {
  PlanGraph plan = Room();
  GetParam().make(plan);
  const absl::Status status = Validate(plan);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr(GetParam().message));
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

INSTANTIATE_TEST_SUITE_P(
    All, FaultyPlanGraph,
    ::testing::Values(Fault{"Corner", [](PlanGraph& plan) { plan.corners[2].point.x() = kNan; }, "corner 2"},
                      Fault{"Index", [](PlanGraph& plan) { plan.walls[3].to = 4; },
                            "wall 3 joins corners 3 and 4, of 4"},
                      Fault{"Length", [](PlanGraph& plan) { plan.walls[1].to = 1; }, "wall 1 has no length"},
                      Fault{"Thickness", [](PlanGraph& plan) { plan.walls[0].thickness = -1; }, "wall 0"},
                      Fault{"Confidence", [](PlanGraph& plan) { plan.walls[0].confidence = 0; }, "wall 0"},
                      Fault{"Door", [](PlanGraph& plan) { plan.doors[0].to.y() = kNan; }, "door 0"},
                      Fault{"Outline", [](PlanGraph& plan) { plan.rooms[0].outline.resize(2); }, "room 0"},
                      Fault{"Scale", [](PlanGraph& plan) { plan.metres_per_unit = 0; }, "0 m a unit"}),
    [](const auto& fault) { return std::string(fault.param.name); });

}  // namespace
}  // namespace enfilade::prior
