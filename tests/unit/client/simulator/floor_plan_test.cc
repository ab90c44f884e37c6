#include "client/simulator/floor_plan.h"

#include <gtest/gtest.h>

#include "tests/support/status_matchers.h"

namespace enfilade::simulator {
namespace {

using enfilade::testing::HasStatus;
using ::testing::HasSubstr;

constexpr std::string_view kRoom = R"(
#####
#a b#
#   #
##  #
#####
)";

TEST(FloorPlan, HasItsOriginAtTheLowerLeft) {
  ASSERT_OK_AND_ASSIGN(const FloorPlan plan, FloorPlan::Parse(kRoom, 0.5));
  ASSERT_EQ(plan.route().size(), 2U);
  EXPECT_EQ(plan.route()[0], Eigen::Vector2d(0.75, 1.75));
  EXPECT_EQ(plan.route()[1], Eigen::Vector2d(1.75, 1.75));
  EXPECT_TRUE(plan.IsWall(1, 1));
  EXPECT_FALSE(plan.IsWall(2, 1));
  EXPECT_TRUE(plan.IsWallAt({0.75, 0.75}));
  EXPECT_TRUE(plan.IsWall(7, 1)) << "outside of the drawing";
  EXPECT_TRUE(plan.IsWall(1, -1));
}

TEST(FloorPlan, MeasuresTheWayToTheWallExactly) {
  ASSERT_OK_AND_ASSIGN(const FloorPlan plan, FloorPlan::Parse(kRoom, 0.5));
  const Eigen::Vector2d a = plan.route()[0];
  EXPECT_DOUBLE_EQ(plan.DistanceToWall(a, {1.0, 0.0}, 9.0), 1.25);
  EXPECT_DOUBLE_EQ(plan.DistanceToWall(a, {-1.0, 0.0}, 9.0), 0.25);
  EXPECT_DOUBLE_EQ(plan.DistanceToWall(a, {0.0, -1.0}, 9.0), 0.75);
  EXPECT_DOUBLE_EQ(plan.DistanceToWall(a, {1.0, 0.0}, 1.0), 1.0) << "the limit";
  // Down to the right past the step's corner at (1, 1): the ray from (0.6, 1.8) meets its top at x = 0.9.
  const Eigen::Vector2d direction = Eigen::Vector2d(0.3, -0.8).normalized();
  EXPECT_NEAR(plan.DistanceToWall({0.6, 1.8}, direction, 9.0), Eigen::Vector2d(0.3, -0.8).norm(), 1e-12);
}

TEST(FloorPlan, RefusesWhatCannotBeDriven) {
  const auto refused = [](std::string_view drawing, double cell, const char* message) {
    EXPECT_THAT(FloorPlan::Parse(drawing, cell), HasStatus(absl::StatusCode::kInvalidArgument, HasSubstr(message)));
  };
  refused("", 0.5, "no rows");
  refused(kRoom, 0.0, "not positive");
  refused("#a#", 0.5, "1 points");
  refused("a b a", 0.5, "two points 'a'");
}

}  // namespace
}  // namespace enfilade::simulator
