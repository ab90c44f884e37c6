// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "tests/contract/storage/suite/contract_test.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class LinkPointSearchTest : public StoreContractTest {
 protected:
  LinkPointSearchTest() {
    storage::Map upstairs = MakeMap(site_, MapId("upstairs"), "Upstairs");
    upstairs.level = 2;
    EXPECT_OK(maps_.Create(Soon(), upstairs, ""));
    EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("lab"), "Lab"), ""));
    EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("yard"), "Yard"), ""));
  }
  void Create(const std::string& id, const std::vector<graph::Anchor>& anchors) {
    ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, id, anchors), ""));
  }
  std::vector<std::string> Find(const storage::LinkPointQuery& query) {
    const auto found = link_points_.Find(Soon(), site_, query);
    EXPECT_OK(found);
    std::vector<std::string> ids;
    for (const auto& link_point : found->link_points) ids.push_back(link_point.point.id.value());
    return ids;
  }
  static storage::LinkPointQuery Around(double x, double y, double radius) {
    storage::LinkPointQuery query;
    query.area = storage::LinkPointCircle{{x, y}, radius};
    return query;
  }
};

TEST_F(LinkPointSearchTest, FindsTheNearestFirst) {
  Create("far", {MakeAnchor("hall", 30, 0)});
  Create("near", {MakeAnchor("hall", 3, 0), MakeAnchor("lab", 0, 0)});
  Create("edge", {MakeAnchor("hall", 0, 20)});
  EXPECT_THAT(Find(Around(0, 0, 20)), ElementsAre("near", "edge"));
  EXPECT_THAT(Find(Around(0, 0, 19.99)), ElementsAre("near"));
  EXPECT_THAT(Find(Around(0, 0, kInfinity)), ElementsAre("near", "edge", "far"));
  storage::LinkPointQuery query = Around(0, 0, kInfinity);
  query.limit = 2;
  EXPECT_THAT(Find(query), ElementsAre("near", "edge"));
  query.candidate = true;
  EXPECT_THAT(Find(query), ElementsAre("edge", "far"));
  query.candidate = false;
  EXPECT_THAT(Find(query), ElementsAre("near"));
  ASSERT_OK(link_points_.SetSuspended(Soon(), site_, LinkPointId("near"), 0, true));
  EXPECT_THAT(Find(query), IsEmpty());
  query.with_unused = true;
  EXPECT_THAT(Find(query), ElementsAre("near"));
}

TEST_F(LinkPointSearchTest, ALiftIsFoundOnItsLevelsAndOnNoneBetween) {
  Create("lift", {MakeAnchor("hall", 1, 0), MakeAnchor("upstairs", 0, 0)});
  Create("door", {MakeAnchor("hall", 2, 0), MakeAnchor("lab", 0, 0)});
  storage::LinkPointQuery query = Around(0, 0, 10);
  query.level = 0;
  EXPECT_THAT(Find(query), ElementsAre("lift", "door"));
  query.level = 1;
  EXPECT_THAT(Find(query), IsEmpty());
  query.level = 2;
  EXPECT_THAT(Find(query), ElementsAre("lift"));
  ASSERT_OK_AND_ASSIGN(storage::Map upstairs, maps_.Get(Soon(), site_, MapId("upstairs")));
  upstairs.level = 1;
  ASSERT_OK(maps_.Update(Soon(), upstairs));
  EXPECT_THAT(Find(query), IsEmpty());
  query.level = 1;
  EXPECT_THAT(Find(query), ElementsAre("lift"));
}

TEST_F(LinkPointSearchTest, FindsInsideAPolygonOnly) {
  Create("in", {MakeAnchor("hall", 1, 1)});
  Create("out", {MakeAnchor("hall", 3, 1)});
  storage::LinkPointQuery query;
  // An L whose notch holds "out".
  query.area = std::vector<Eigen::Vector2d>{{0, 0}, {4, 0}, {4, 0.5}, {2, 0.5}, {2, 4}, {0, 4}};
  EXPECT_THAT(Find(query), ElementsAre("in"));
  query.level = 2;
  EXPECT_THAT(Find(query), IsEmpty());
  query.area = std::vector<Eigen::Vector2d>{{0, 0}, {4, 0}};
  EXPECT_CODE(link_points_.Find(Soon(), site_, query), absl::StatusCode::kInvalidArgument);
  query.area = storage::LinkPointCircle{{0, 0}, -1.0};
  EXPECT_CODE(link_points_.Find(Soon(), site_, query), absl::StatusCode::kInvalidArgument);
  query.area = storage::LinkPointCircle{{std::nan(""), 0}, 1.0};
  EXPECT_CODE(link_points_.Find(Soon(), site_, query), absl::StatusCode::kInvalidArgument);
}

TEST_F(LinkPointSearchTest, PlacesFollowFromTheRootThroughLinkPoints) {
  const double quarter = std::numbers::pi / 2;
  // "lab" and "upstairs" hang together before either is joined to the hall.
  Create("stairs", {MakeAnchor("lab", 5, 0), MakeAnchor("upstairs", 1, 1)});
  Create("candidate", {MakeAnchor("upstairs", 3, 1)});
  EXPECT_THAT(Find(Around(0, 0, kInfinity)), IsEmpty());
  ASSERT_OK_AND_ASSIGN(const auto unplaced, link_points_.ListUnplaced(Soon(), site_, 10));
  EXPECT_EQ(unplaced.size(), 2U);
  Create("door", {MakeAnchor("hall", 10, 0, quarter), MakeAnchor("lab", 0, 0)});
  ASSERT_OK_AND_ASSIGN(const auto stairs, link_points_.Get(Soon(), site_, LinkPointId("stairs")));
  ASSERT_TRUE(stairs.T_world_place);
  EXPECT_THAT(stairs.T_world_place->pose, PoseNear(Pose2{10, 5, quarter}, 1e-9, 1e-9));
  ASSERT_OK_AND_ASSIGN(const auto candidate, link_points_.Get(Soon(), site_, LinkPointId("candidate")));
  ASSERT_TRUE(candidate.T_world_place);
  EXPECT_THAT(candidate.T_world_place->pose, PoseNear(Pose2{10, 7, quarter}, 1e-9, 1e-9));
  EXPECT_GT(candidate.T_world_place->covariance.trace(), stairs.T_world_place->covariance.trace());
  ASSERT_OK_AND_ASSIGN(const auto places, graph_.GetPlaces(Soon(), site_, {}));
  EXPECT_EQ(places.size(), 3U);
}

TEST_F(LinkPointSearchTest, ALimitTakesTheNearestOfACircleAndTheFirstOfAPolygon) {
  for (int i = 0; i < 6; ++i) Create("p" + std::to_string(i), {MakeAnchor("hall", 10.0 - i, 0)});
  storage::LinkPointQuery query = Around(0, 0, 100);
  query.limit = 2;
  EXPECT_THAT(Find(query), ElementsAre("p5", "p4"));
  query.area = std::vector<Eigen::Vector2d>{{-1, -1}, {20, -1}, {20, 1}, {-1, 1}};
  EXPECT_THAT(Find(query), ElementsAre("p0", "p1"));
}

TEST_F(LinkPointSearchTest, WhatIsEquallyNearComesById) {
  Create("b", {MakeAnchor("hall", 0, 2)});
  Create("c", {MakeAnchor("hall", 2, 0)});
  Create("a", {MakeAnchor("hall", -2, 0)});
  EXPECT_THAT(Find(Around(0, 0, 5)), ElementsAre("a", "b", "c"));
}

TEST_F(LinkPointSearchTest, ReportsTheVersionOfTheGraphEvenIfNothingIsFound) {
  Create("door", {MakeAnchor("hall", 3, 0)});
  ASSERT_OK_AND_ASSIGN(const std::int64_t version, graph_.GetVersion(Soon(), site_));
  ASSERT_OK_AND_ASSIGN(const auto found, link_points_.Find(Soon(), site_, Around(3, 0, 1)));
  EXPECT_EQ(found.graph_version, version);
  ASSERT_OK_AND_ASSIGN(const auto nothing, link_points_.Find(Soon(), site_, Around(50, 0, 1)));
  EXPECT_THAT(nothing.link_points, IsEmpty());
  EXPECT_EQ(nothing.graph_version, version);
  ASSERT_OK_AND_ASSIGN(const auto nowhere, link_points_.Find(Soon(), SiteId("nowhere"), Around(0, 0, 1)));
  EXPECT_EQ(nowhere.graph_version, 0);
}

TEST_F(LinkPointSearchTest, ASolutionMovesWhatIsFound) {
  Create("door", {MakeAnchor("hall", 3, 0)});
  ASSERT_OK_AND_ASSIGN(const std::int64_t version, graph_.GetVersion(Soon(), site_));
  storage::GraphSolution solution;
  solution.link_points = {{LinkPointId("door"), {{40, 0, 0}, Eigen::Matrix3d::Identity()}}};
  ASSERT_OK(graph_.Apply(Soon(), site_, version, solution));
  EXPECT_THAT(Find(Around(3, 0, 1)), IsEmpty());
  EXPECT_THAT(Find(Around(40, 0, 1)), ElementsAre("door"));
}

TEST_F(LinkPointSearchTest, FindsWhatASearchThroughAllFinds) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> coordinate(-30.0, 30.0);
  std::vector<std::pair<std::string, Eigen::Vector2d>> all;
  for (int i = 10; i < 70; ++i) {
    const Eigen::Vector2d position(coordinate(random), coordinate(random));
    all.emplace_back("p" + std::to_string(i), position);
    Create(all.back().first, {MakeAnchor("hall", position.x(), position.y())});
  }
  for (int round = 0; round < 15; ++round) {
    const Eigen::Vector2d center(coordinate(random), coordinate(random));
    const double radius = std::abs(coordinate(random)) / 2.0;
    std::vector<std::string> near, in_box;
    std::sort(all.begin(), all.end(),
              [&](const auto& a, const auto& b) { return (a.second - center).norm() < (b.second - center).norm(); });
    for (const auto& [id, position] : all) {
      if ((position - center).norm() <= radius) near.push_back(id);
      if ((position - center).cwiseAbs().maxCoeff() < radius) in_box.push_back(id);
    }
    EXPECT_EQ(Find(Around(center.x(), center.y(), radius)), near) << round;
    std::sort(in_box.begin(), in_box.end());
    storage::LinkPointQuery box;
    std::vector<Eigen::Vector2d> corners;
    for (const auto& [x, y] : std::vector<std::pair<int, int>>{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      corners.emplace_back(center.x() + x * radius, center.y() + y * radius);
    }
    box.area = corners;
    EXPECT_EQ(Find(box), in_box) << round;
  }
}

TEST_F(LinkPointSearchTest, ALinkPointIsPlacedByItsMostCertainAnchor) {
  graph::Anchor vague = MakeAnchor("hall", 10, 0);
  vague.covariance = Eigen::Matrix3d::Identity();
  Create("door", {vague, MakeAnchor("lab", 0, 0)});  // places the lab at (10, 0), vaguely
  Create("second", {MakeAnchor("hall", 10.5, 3), MakeAnchor("lab", 0, 3)});
  ASSERT_OK_AND_ASSIGN(const auto second, link_points_.Get(Soon(), site_, LinkPointId("second")));
  ASSERT_TRUE(second.T_world_place);
  EXPECT_EQ(second.T_world_place->pose.x, 10.5) << "by the hall, not by the lab";
  ASSERT_OK_AND_ASSIGN(const auto lab, graph_.GetPlaces(Soon(), site_, {MapId("lab")}));
  ASSERT_THAT(lab, SizeIs(1));
  EXPECT_THAT(lab[0].T_world_map.pose, PoseNear(Pose2{10, 0, 0}, 1e-9, 1e-9)) << "a map keeps its place";
}

TEST_F(LinkPointSearchTest, ASuspendedLinkPointPlacesNoMap) {
  Create("door", {MakeAnchor("yard", 0, 0), MakeAnchor("lab", 0, 0)});
  ASSERT_OK(link_points_.SetSuspended(Soon(), site_, LinkPointId("door"), 0, true));
  Create("gate", {MakeAnchor("hall", 5, 0), MakeAnchor("yard", 0, 0)});
  ASSERT_OK_AND_ASSIGN(const auto places, graph_.GetPlaces(Soon(), site_, {}));
  EXPECT_THAT(places, SizeIs(2)) << "the hall and the yard";
  EXPECT_THAT(Find(Around(5, 0, 1)), ElementsAre("gate"));
  ASSERT_OK(link_points_.SetSuspended(Soon(), site_, LinkPointId("door"), 0, false));
  ASSERT_OK_AND_ASSIGN(const auto resumed, graph_.GetPlaces(Soon(), site_, {}));
  EXPECT_THAT(resumed, SizeIs(3));
}

}  // namespace
}  // namespace enfilade::testing
