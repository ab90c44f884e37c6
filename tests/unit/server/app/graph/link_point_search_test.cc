// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/link_point_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A pose whose position has standard deviations of `sx` and `sy` metres.
PoseWithCovariance PoseAt(const Pose2& pose, double sx = 0.0, double sy = 0.0) {
  return {pose, Eigen::Vector3d(sx * sx, sy * sy, 0.0).asDiagonal()};
}

const storage::LinkPointCircle& CircleOf(const LinkPointSearchPlan& plan) {
  return std::get<storage::LinkPointCircle>(plan.query->area);
}

TEST(PlanLinkPointSearch, GrowsTheRadiusWithTheUncertaintyOfThePose) {
  LinkPointSearch search{.around = PoseAt({3, 4, 1})};
  ASSERT_OK_AND_ASSIGN(const auto exact, PlanLinkPointSearch(search, std::nullopt));
  EXPECT_DOUBLE_EQ(CircleOf(exact).radius, 20.0);
  EXPECT_EQ(CircleOf(exact).center, Eigen::Vector2d(3, 4));

  search.around = PoseAt({3, 4, 1}, 2.0, 1.0);
  ASSERT_OK_AND_ASSIGN(const auto uncertain, PlanLinkPointSearch(search, std::nullopt));
  EXPECT_NEAR(CircleOf(uncertain).radius, 20.0 + 2.0 * std::sqrt(5.991 * 4.0), 1e-9) << "by the larger eigenvalue";

  search.radius = {.base_m = 1.0, .factor = 0.5};
  ASSERT_OK_AND_ASSIGN(const auto narrow, PlanLinkPointSearch(search, std::nullopt));
  EXPECT_NEAR(CircleOf(narrow).radius, 1.0 + 0.5 * std::sqrt(5.991 * 4.0), 1e-9);
}

TEST(PlanLinkPointSearch, RefusesARadiusThatIsNotPositiveAndFinite) {
  for (const double number : {0.0, -1.0, kInfinity, std::nan("")}) {
    LinkPointSearch search{.around = PoseAt({})};
    search.radius.base_m = number;
    EXPECT_STATUS(PlanLinkPointSearch(search, std::nullopt), absl::StatusCode::kInvalidArgument,
                  HasSubstr("base_radius_m"));
    search.radius = {.base_m = 1.0, .factor = number};
    EXPECT_STATUS(PlanLinkPointSearch(search, std::nullopt), absl::StatusCode::kInvalidArgument,
                  HasSubstr("radius_factor"));
    search.around = storage::LinkPointCircle{{0, 0}, 1.0};
    EXPECT_OK(PlanLinkPointSearch(search, std::nullopt)) << "a circle has a radius of its own";
  }
}

TEST(PlanLinkPointSearch, TakesAPoseInAMapIntoTheWorld) {
  const LinkPointSearch search{.around = PoseInMap{MapId("b"), PoseAt({1, 0, 0}, 0.5)}};
  const PoseWithCovariance T_world_map = PoseAt({10, 20, M_PI / 2.0}, 1.0, 1.0);
  ASSERT_OK_AND_ASSIGN(const auto plan, PlanLinkPointSearch(search, T_world_map));
  EXPECT_NEAR(plan.T_world_center->pose.x, 10.0, 1e-9);
  EXPECT_NEAR(plan.T_world_center->pose.y, 21.0, 1e-9);
  EXPECT_NEAR(CircleOf(plan).center.y(), 21.0, 1e-9);
  // Both uncertainties count; the robot's lies along the map's x axis, which is the world's y axis.
  EXPECT_NEAR(CircleOf(plan).radius, 20.0 + 2.0 * std::sqrt(5.991 * 1.25), 1e-9);
  EXPECT_FALSE(plan.with_unplaced);
}

TEST(PlanLinkPointSearch, AnswersInAnUnplacedMapWithAllThatIsUnplaced) {
  const LinkPointSearch search{.around = PoseInMap{MapId("b"), PoseAt({1, 0, 0})}};
  ASSERT_OK_AND_ASSIGN(const auto plan, PlanLinkPointSearch(search, std::nullopt));
  EXPECT_FALSE(plan.query.has_value()) << "nothing is at a known distance";
  EXPECT_FALSE(plan.T_world_center.has_value());
  EXPECT_TRUE(plan.with_unplaced);
}

TEST(PlanLinkPointSearch, SearchesCirclesAndPolygonsAsTheyAre) {
  LinkPointSearch search{.around = storage::LinkPointCircle{{1, 2}, kInfinity}};
  ASSERT_OK_AND_ASSIGN(const auto circle, PlanLinkPointSearch(search, PoseAt({100, 100, 0})));
  EXPECT_EQ(CircleOf(circle).radius, kInfinity);
  EXPECT_EQ(CircleOf(circle).center, Eigen::Vector2d(1, 2)) << "a map's place is for poses in it";
  EXPECT_EQ(circle.T_world_center->pose, (Pose2{1, 2, 0}));

  const std::vector<Eigen::Vector2d> corners = {{0, 0}, {1, 0}, {0, 1}};
  search.around = corners;
  ASSERT_OK_AND_ASSIGN(const auto polygon, PlanLinkPointSearch(search, std::nullopt));
  EXPECT_EQ(std::get<std::vector<Eigen::Vector2d>>(polygon.query->area), corners);
  EXPECT_FALSE(polygon.T_world_center.has_value());
}

TEST(PlanLinkPointSearch, PassesTheFiltersOn) {
  const LinkPointSearch search{
      .around = PoseAt({}), .limit = 17, .level = -1, .candidate = true, .with_unused = true, .with_unplaced = true};
  ASSERT_OK_AND_ASSIGN(const auto plan, PlanLinkPointSearch(search, std::nullopt));
  EXPECT_EQ(plan.query->limit, 17);
  EXPECT_EQ(plan.query->level, std::optional(-1));
  EXPECT_EQ(plan.query->candidate, std::optional(true));
  EXPECT_TRUE(plan.query->with_unused);
  EXPECT_TRUE(plan.with_unplaced);
}

TEST(OffsetFrom, HasDistanceBearingAndMahalanobisDistance) {
  storage::StoredLinkPoint link_point;
  link_point.T_world_place = PoseAt({3, 5, 0}, 1.0, 1.0);
  const auto offset = OffsetFrom(PoseAt({3, 2, M_PI}, 1.0, std::sqrt(3.0)), link_point);
  ASSERT_TRUE(offset.has_value());
  EXPECT_DOUBLE_EQ(offset->distance_m, 3.0);
  EXPECT_NEAR(offset->bearing_rad, M_PI / 2.0, 1e-12) << "from the world's axis, however the robot is turned";
  EXPECT_NEAR(offset->mahalanobis_distance, 3.0 / 2.0, 1e-12);
}

TEST(OffsetFrom, IsInfinitelyUnlikelyBetweenExactPositionsThatDiffer) {
  storage::StoredLinkPoint link_point;
  link_point.T_world_place = PoseAt({3, 5, 0});
  EXPECT_EQ(OffsetFrom(PoseAt({3, 2, 0}), link_point)->mahalanobis_distance, kInfinity);
  EXPECT_EQ(OffsetFrom(PoseAt({3, 5, 0}), link_point)->mahalanobis_distance, 0.0);
}

TEST(OffsetFrom, IsUnknownWithoutACentreOrAPlace) {
  storage::StoredLinkPoint link_point;
  EXPECT_FALSE(OffsetFrom(PoseAt({}), link_point).has_value());
  link_point.T_world_place = PoseAt({});
  EXPECT_FALSE(OffsetFrom(std::nullopt, link_point).has_value());
}

}  // namespace
}  // namespace enfilade::server
