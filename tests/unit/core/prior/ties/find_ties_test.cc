// SPDX-License-Identifier: Apache-2.0
#include "core/prior/ties/find_ties.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <queue>
#include <set>

#include "core/graph/graph_optimization.h"
#include "core/prior/fit/fit_plan.h"
#include "tests/support/plans/drawn_building.h"
#include "tests/support/status_assertions.h"

namespace enfilade::prior {
namespace {

using ::testing::IsEmpty;

constexpr Pose2 kPlaceOfEast{12.0, -4.0, 2.2};  // T_west_east

// Where the plan lies in the map of the west.
PlanTransform Truth() {
  const double turn = 0.3;
  Eigen::Matrix2d rotation;
  rotation << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
  return {0.05 * rotation * Eigen::Vector2d(1, -1).asDiagonal(), {3.5, -7.25}};
}
bool IsWest(const Eigen::Vector2d& sheet) { return sheet.x() < 520; }
bool IsEast(const Eigen::Vector2d& sheet) { return sheet.x() > 330; }

class FindTiesTest : public ::testing::Test {
 protected:
  // Two maps, placed by the plan as it is drawn in `plan_`; `as_built` is what robots see.
  void Fit(const PlanGraph& as_built) {
    const Pose2 T_east_west = Inverse(kPlaceOfEast);
    grids_ = {MapOf(as_built, Truth(), IsWest), MapOf(as_built, T_east_west * Truth(), IsEast)};
    ASSERT_OK_AND_ASSIGN(fit_, FitPlan(plan_, grids_, {}));
    ASSERT_TRUE(fit_.alignment.accepted) << fit_.alignment.reason;
    ASSERT_TRUE(fit_.maps[1].T_first_map.has_value());
    west_ = EvidenceOf(grids_[0]);
    east_ = EvidenceOf(grids_[1]);
    ties_ = FindTies(plan_, fit_.alignment.T_map_sheet, *fit_.corrected,
                     {{MapId("west"), &west_, {}}, {MapId("east"), &east_, *fit_.maps[1].T_first_map}});
  }
  // Of what is seen, across the wall as it is built.
  double ErrorOf(const graph::WallSighting& sighting, const PlanGraph& as_built) const {
    const Pose2 T_world_map = sighting.map == MapId("west") ? Pose2{} : kPlaceOfEast;
    const PlanWall& wall =
        as_built.walls[static_cast<std::size_t>(ties_.struts[static_cast<std::size_t>(sighting.strut)].wall)];
    const Eigen::Vector2d from = Truth()(as_built.corners[static_cast<std::size_t>(wall.from)].point);
    const Eigen::Vector2d to = Truth()(as_built.corners[static_cast<std::size_t>(wall.to)].point);
    const Eigen::Vector2d along = (to - from).normalized();
    const Pose2 T_world_line = T_world_map * sighting.T_map_line;
    EXPECT_NEAR(WrapAngle(T_world_line.yaw - std::atan2(along.y(), along.x())), 0.0, 0.02);
    return Eigen::Vector2d(-along.y(), along.x()).dot(T_world_line.translation() - from);
  }

  PlanGraph plan_ = DrawnBuilding();
  std::vector<grid::OccupancyGrid> grids_;
  PlanFit fit_;
  MapEvidence west_, east_;
  graph::PlanTies ties_;
};

TEST_F(FindTiesTest, WallsAreWhereTheyAreBuilt) {
  Fit(plan_);
  ASSERT_EQ(ties_.maps.size(), 2U);
  EXPECT_EQ(ties_.maps[0].map, MapId("east"));
  EXPECT_GT(ties_.sightings.size(), 30U);
  for (const graph::WallSighting& sighting : ties_.sightings) {
    EXPECT_LT(std::abs(ErrorOf(sighting, plan_)), 0.06);
    EXPECT_GE(sighting.length, 0.8);
  }
  EXPECT_OK(graph::DecodePlanTies(graph::EncodePlanTies(ties_)).status());
  // And they hang together.
  std::vector<std::vector<int>> neighbours(ties_.corners.size());
  for (const graph::PlanStrut& strut : ties_.struts) {
    neighbours[static_cast<std::size_t>(strut.from)].push_back(strut.to);
    neighbours[static_cast<std::size_t>(strut.to)].push_back(strut.from);
  }
  std::set<int> reached = {ties_.struts.front().from};
  std::queue<int> next({ties_.struts.front().from});
  for (; !next.empty(); next.pop()) {
    for (const int corner : neighbours[static_cast<std::size_t>(next.front())]) {
      if (reached.insert(corner).second) next.push(corner);
    }
  }
  EXPECT_EQ(reached.size(), ties_.corners.size());
}

TEST_F(FindTiesTest, ShaftsWithANameAreHeldByTheCornersAroundThem) {
  const auto add = [&](const std::string& name, double x, double y) {  // m
    plan_.shafts.push_back(
        {ShaftKind::kLift,
         {{20 * x, 20 * y}, {20 * x + 40, 20 * y}, {20 * x + 40, 20 * y + 32}, {20 * x, 20 * y + 32}},
         name});
  };
  add("A", 12.2, 0.2);
  add("", 26.2, 0.2);
  add("B", 41.8, 14.2);
  Fit(plan_);
  ASSERT_EQ(ties_.shafts.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const graph::ShaftInPlan& shaft = ties_.shafts[i];
    EXPECT_EQ(shaft.name, i == 0 ? "A" : "B");
    EXPECT_TRUE(shaft.is_lift);
    const Eigen::Vector2d middle = i == 0 ? Eigen::Vector2d(13.2, 1.0) : Eigen::Vector2d(42.8, 15.0);
    EXPECT_LT((shaft.middle() - Truth()(20 * middle)).norm(), 0.1);
    double area = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector2d a = shaft.outline[k] - shaft.middle(), b = shaft.outline[(k + 1) % 4] - shaft.middle();
      area += 0.5 * (a.x() * b.y() - a.y() * b.x());
    }
    EXPECT_NEAR(area, 3.2, 0.1) << "counter-clockwise";
  }
  // The nearest corner of the room that it stands in.
  const auto holder = [&](std::size_t shaft, const Eigen::Vector2d& built) {
    double least = 1e9;
    for (const int corner : ties_.shafts[shaft].held_by) {
      least = std::min(least, (ties_.corners[static_cast<std::size_t>(corner)] - Truth()(20 * built)).norm());
    }
    return least;
  };
  EXPECT_LT(holder(0, {12.0, 0.0}), 0.1);
  EXPECT_LT(holder(1, {44.0, 16.0}), 0.1);
  EXPECT_OK(graph::DecodePlanTies(graph::EncodePlanTies(ties_)).status());
}

TEST_F(FindTiesTest, TheGraphPosesAMapByThem) {
  // A tenth of a metre off, corner by corner.
  PlanGraph as_built = plan_;
  for (std::size_t i = 0; i < as_built.corners.size(); ++i) {
    as_built.corners[i].point += 2.0 * Eigen::Vector2d(std::sin(17.0 * i), std::cos(29.0 * i));
  }
  Fit(as_built);
  graph::SnapshotChanges changes{
      .version = 1, .root = MapId("west"), .maps = {{.id = MapId("west")}, {.id = MapId("east")}}};
  changes.plans = {{PriorMapId("plan"), "digest", std::make_shared<const graph::PlanTies>(ties_)}};
  ASSERT_OK_AND_ASSIGN(const graph::GraphSnapshot graph, graph::Apply({}, changes));
  ASSERT_OK_AND_ASSIGN(const graph::SolvedGraph solution, graph::OptimizeGraph(graph));
  ASSERT_THAT(solution.disconnected, IsEmpty()) << solution.plans.at(0).contradiction;
  const PoseWithCovariance& east = solution.map_poses.at(MapId("east"));
  const Pose2 error = Between(kPlaceOfEast, east.pose);
  EXPECT_LT(error.translation().norm(), 0.15);
  EXPECT_LT(std::abs(error.yaw), 0.01);
  EXPECT_LT(std::sqrt(east.covariance(0, 0) + east.covariance(1, 1)), 0.5);
}

}  // namespace
}  // namespace enfilade::prior
