// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/pose_updates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Root "a" and "b" behind a door at (`door_x`, 0); "far" is joined to nothing.
std::shared_ptr<const SiteGraph> MakeGraph(std::int64_t version, double door_x = 5.0) {
  graph::SnapshotChanges changes{.version = version, .root = MapId("a")};
  for (const char* id : {"a", "b", "far"}) changes.maps.push_back({.id = MapId(id)});
  graph::LinkPoint door;
  door.id = LinkPointId("door");
  door.anchors = {{MapId("a"), {door_x, 0, 0}, graph::DefaultAnchorCovariance()},
                  {MapId("b"), {0, 0, 0}, graph::DefaultAnchorCovariance()}};
  changes.link_points = {door};
  auto snapshot = Apply(graph::GraphSnapshot(), changes);
  EXPECT_OK(snapshot);
  return std::make_shared<SiteGraph>(*std::move(snapshot));
}

storage::RobotPose At(const std::string& robot, const std::string& map, double x, std::int64_t version) {
  storage::RobotPose report;
  report.site = SiteId("s");
  report.robot = RobotId(robot);
  report.map = MapId(map);
  report.T_map_robot = {{x, 0, 0}, 0.01 * Eigen::Matrix3d::Identity()};
  report.version = version;
  return report;
}

class PoseUpdatesTest : public ::testing::Test {
 protected:
  // The site's next moment.
  const SitePoses& Moment(const std::shared_ptr<const SiteGraph>& graph,
                          const std::vector<storage::RobotPose>& reports) {
    const auto next = Following(poses_, graph, reports);
    EXPECT_OK(next);
    if (next.ok()) poses_ = *next;
    return *poses_;
  }
  // The robots of the next updates.
  std::vector<std::string> Next(PoseUpdates& updates, const std::shared_ptr<const SiteGraph>& graph,
                                const std::vector<storage::RobotPose>& reports) {
    std::vector<std::string> robots;
    for (const SitePoses::OfRobot* update : updates.Next(Moment(graph, reports))) {
      robots.push_back(update->report.robot.value());
    }
    return robots;
  }

  std::shared_ptr<const SitePoses> poses_;
};

TEST_F(PoseUpdatesTest, BeginsWithEveryRobotThatHasReported) {
  PoseUpdates updates({}, {});
  const auto next = updates.Next(Moment(MakeGraph(3), {At("r1", "a", 1, 7), At("r2", "b", 1, 8)}));
  ASSERT_EQ(next.size(), 2U);
  EXPECT_EQ(next[0]->pose->T_world_robot.pose.x, 1.0);
  EXPECT_EQ(next[1]->pose->T_world_robot.pose.x, 6.0);
  EXPECT_EQ(updates.position(), (PoseUpdates::Position{3, 8}));
}

TEST_F(PoseUpdatesTest, IsSilentUntilARobotReportsAgain) {
  PoseUpdates updates({}, {});
  const auto graph = MakeGraph(3);
  Next(updates, graph, {At("r1", "a", 1, 7), At("r2", "a", 2, 8)});
  EXPECT_THAT(Next(updates, graph, {At("r1", "a", 1, 7), At("r2", "a", 2, 8)}), IsEmpty());
  EXPECT_THAT(Next(updates, graph, {At("r1", "a", 1, 9), At("r2", "a", 2, 8)}), ElementsAre("r1"))
      << "a new report counts even at the same place";
  EXPECT_THAT(Next(updates, graph, {At("r1", "a", 1, 9), At("r2", "a", 2, 8), At("r3", "a", 0, 10)}),
              ElementsAre("r3"));
}

TEST_F(PoseUpdatesTest, AMomentAtWhichNothingChangesIsTheOneBefore) {
  const auto graph = MakeGraph(3);
  const std::vector<storage::RobotPose> reports = {At("r1", "a", 1, 7)};
  const SitePoses* const first = &Moment(graph, reports);
  EXPECT_EQ(&Moment(graph, reports), first);
  EXPECT_NE(&Moment(graph, {At("r1", "a", 1, 8)}), first);
}

TEST_F(PoseUpdatesTest, WatchersOfOneSiteHearEachAtItsOwnRate) {
  PoseUpdates often({}, {}), seldom({}, {});
  const auto graph = MakeGraph(3);
  Next(often, graph, {At("r1", "a", 1, 7), At("r2", "a", 1, 8)});
  Next(seldom, graph, {At("r1", "a", 1, 7), At("r2", "a", 1, 8)});
  EXPECT_THAT(Next(often, graph, {At("r1", "a", 1, 9), At("r2", "a", 1, 8)}), ElementsAre("r1"));
  EXPECT_THAT(Next(often, graph, {At("r1", "a", 1, 9), At("r2", "a", 1, 10)}), ElementsAre("r2"));
  EXPECT_THAT(Next(seldom, graph, {At("r1", "a", 5, 11), At("r2", "a", 1, 10)}), ElementsAre("r1", "r2"));
  EXPECT_THAT(Next(often, graph, {At("r1", "a", 5, 11), At("r2", "a", 1, 10)}), ElementsAre("r1"));
}

TEST_F(PoseUpdatesTest, ReportsRobotsThatTheGraphHasMoved) {
  PoseUpdates updates({}, {});
  const std::vector<storage::RobotPose> reports = {At("in-a", "a", 1, 7), At("in-b", "b", 1, 8)};
  Next(updates, MakeGraph(3), reports);
  EXPECT_THAT(Next(updates, MakeGraph(4), reports), IsEmpty()) << "a new version that moves nothing";
  EXPECT_THAT(Next(updates, MakeGraph(5, 5.5), reports), ElementsAre("in-b"));
  EXPECT_EQ(updates.position(), (PoseUpdates::Position{5, 8}));
}

TEST_F(PoseUpdatesTest, ReportsRobotsWithoutAPlaceInTheWorldOnce) {
  PoseUpdates updates({}, {});
  const auto next = updates.Next(Moment(MakeGraph(3), {At("r1", "far", 1, 7)}));
  ASSERT_EQ(next.size(), 1U);
  EXPECT_FALSE(next[0]->pose.has_value());
  EXPECT_THAT(Next(updates, MakeGraph(4), {At("r1", "far", 1, 7)}), IsEmpty());
  EXPECT_THAT(Next(updates, MakeGraph(4), {At("r1", "a", 1, 8)}), ElementsAre("r1")) << "it has come into the world";
}

TEST_F(PoseUpdatesTest, FollowsOnlyTheRobotsAskedFor) {
  PoseUpdates updates({}, {RobotId("r2"), RobotId("r3")});
  const auto graph = MakeGraph(3);
  EXPECT_THAT(Next(updates, graph, {At("r1", "a", 1, 9), At("r2", "a", 2, 8)}), ElementsAre("r2"));
  EXPECT_EQ(updates.position().report_version, 8) << "others' reports do not count";
}

TEST_F(PoseUpdatesTest, ResumesWhereAnEarlierWatchStopped) {
  const std::vector<storage::RobotPose> reports = {At("new", "b", 1, 9), At("old", "a", 1, 7)};
  PoseUpdates resumed({.graph_version = 3, .report_version = 8}, {});
  EXPECT_THAT(Next(resumed, MakeGraph(3), reports), ElementsAre("new"));
  EXPECT_EQ(resumed.position(), (PoseUpdates::Position{3, 9}));
  // What was seen before the resumption is not new afterwards either, and what changes then is.
  EXPECT_THAT(Next(resumed, MakeGraph(3), reports), IsEmpty());
  EXPECT_THAT(Next(resumed, MakeGraph(4, 7.0), reports), ElementsAre("new"));
}

TEST_F(PoseUpdatesTest, ResumesWithEverythingIfTheGraphHasChangedMeanwhile) {
  PoseUpdates resumed({.graph_version = 2, .report_version = 100}, {});
  EXPECT_THAT(Next(resumed, MakeGraph(3), {At("r1", "a", 1, 7)}), ElementsAre("r1"))
      << "its map may have moved: nobody knows where it was";
  EXPECT_EQ(resumed.position(), (PoseUpdates::Position{3, 100})) << "the greatest report version never falls";
}

TEST_F(PoseUpdatesTest, WaitsForTheGraphOfAMapThatIsNew) {
  PoseUpdates updates({}, {});
  EXPECT_THAT(Next(updates, MakeGraph(3), {At("r1", "not-yet", 1, 7)}), IsEmpty());
  graph::SnapshotChanges changes{.version = 4, .root = MapId("not-yet")};
  changes.maps.push_back({.id = MapId("not-yet")});
  ASSERT_OK_AND_ASSIGN(auto snapshot, Apply(graph::GraphSnapshot(), changes));
  EXPECT_THAT(Next(updates, std::make_shared<SiteGraph>(std::move(snapshot)), {At("r1", "not-yet", 1, 7)}),
              ElementsAre("r1"));
}

}  // namespace
}  // namespace enfilade::server
