// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/site_graph.h"

#include <gmock/gmock.h>

#include "core/graph/graph_optimization.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/server/app/test_values.h"

namespace enfilade::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const SiteId kCampus("campus");

graph::GraphSnapshot Snapshot(const storage::GraphChanges& changes) {
  auto graph = graph::Apply(graph::GraphSnapshot(), ToSnapshotChanges(changes));
  EXPECT_OK(graph);
  return *graph;
}

// Maps a (the root), b, c and the unconnected d.
storage::GraphChanges Changes(const std::vector<storage::StoredLinkPoint>& link_points) {
  storage::GraphChanges changes;
  changes.version = 7;
  changes.complete = true;
  changes.root = MapId("a");
  for (const char* id : {"a", "b", "c", "d"}) changes.maps.emplace_back().id = MapId(id);
  changes.link_points = link_points;
  return changes;
}

TEST(ToSnapshotChanges, AMapThatWasDeletedAndCreatedAgainStays) {
  storage::GraphChanges changes;
  changes.version = 8;
  changes.root = MapId("a");
  changes.removed_maps = {MapId("b"), MapId("gone")};
  changes.maps.emplace_back().id = MapId("b");
  changes.maps.back().level = 2;
  const graph::SnapshotChanges converted = ToSnapshotChanges(changes);
  EXPECT_THAT(converted.removed_maps, ElementsAre(MapId("gone")));
  ASSERT_EQ(converted.maps.size(), 1U);
  EXPECT_EQ(converted.maps[0].level, 2);
  EXPECT_EQ(converted.version, 8);
}

TEST(ToSolvedGraph, RefusesPosesInAnotherRootsFrame) {
  const MapId a("a");
  const MapId b("b");
  const PoseWithCovariance origin{{}, Eigen::Matrix3d::Zero()};
  const PoseWithCovariance elsewhere{{1, 2, 3}, Eigen::Matrix3d::Identity()};
  const auto solved = ToSolvedGraph(nullptr, {{{a, origin}, {b, elsewhere}}, {}}, 5, a);
  ASSERT_NE(solved, nullptr);
  EXPECT_EQ(solved->graph_version, 5);
  EXPECT_EQ(solved->root, a);
  EXPECT_EQ(solved->map_poses.at(b).pose, elsewhere.pose);
  EXPECT_EQ(ToSolvedGraph(nullptr, {{{a, origin}, {b, elsewhere}}, {}}, 5, b), nullptr) << "b is not at the origin";
  EXPECT_EQ(ToSolvedGraph(nullptr, {{{b, elsewhere}}, {}}, 5, a), nullptr) << "the root is not part of it";
  EXPECT_EQ(ToSolvedGraph(nullptr, {{{a, {{}, Eigen::Matrix3d::Identity()}}}, {}}, 5, a), nullptr)
      << "the root's pose is exact";
  EXPECT_EQ(ToSolvedGraph(nullptr, {}, 5, a), nullptr);
}

TEST(ToSolvedGraph, AppliesChangesToTheSolutionBefore) {
  const PoseWithCovariance origin{{}, Eigen::Matrix3d::Zero()};
  const PoseWithCovariance elsewhere{{1, 2, 3}, Eigen::Matrix3d::Identity()};
  const MapId a("a"), b("b"), c("c");
  const auto old = ToSolvedGraph(nullptr, {{{a, origin}, {b, elsewhere}}, {}}, 5, a);
  const auto solved = ToSolvedGraph(old.get(), {{{c, elsewhere}}, {b}}, 6, a);
  EXPECT_EQ(solved->graph_version, 6);
  EXPECT_TRUE(solved->map_poses.contains(a));
  EXPECT_FALSE(solved->map_poses.contains(b));
  EXPECT_TRUE(solved->map_poses.contains(c));
  EXPECT_TRUE(old->map_poses.contains(b)) << "readers of the one before keep it";
}

TEST(FitControlPoints, NamesTheMapThatIsNotJoinedToTheRoot) {
  const graph::WorldPoses poses(Snapshot(Changes({MakeDoor(kCampus, "ab", "a", "b", {100, 0, 0})})));
  // About 111 m apart on the globe; 100 m + 11 m in the world frame.
  const storage::ControlPoint at_a{MapId("a"), {0, 0}, 48.0, 11.0};
  const storage::ControlPoint at_b{MapId("b"), {11.2, 0}, 48.001, 11.0};
  ASSERT_OK_AND_ASSIGN(const geo::GeoreferenceFit fit, FitControlPoints(poses, {at_a, at_b}));
  EXPECT_STATUS(FitControlPoints(poses, {at_a, {MapId("d"), {0, 0}, 48.001, 11.0}}),
                absl::StatusCode::kFailedPrecondition, HasSubstr("map d"));
  EXPECT_FALSE(FitControlPoints(poses, {at_a}).ok()) << "one point fixes no rotation";
}

TEST(ToStored, CountsTheResidualsThatTheSolutionWasMadeFrom) {
  storage::StoredLinkPoint hall = MakeDoor(kCampus, "hall", "a", "b", {5, 0, 0});
  hall.point.anchors.push_back({MapId("c"), {0, 5, 0}, graph::DefaultAnchorCovariance()});
  storage::StoredLinkPoint candidate = MakeDoor(kCampus, "candidate", "a", "b", {1, 1, 0});
  candidate.point.anchors.pop_back();
  storage::StoredLinkPoint suspended = MakeDoor(kCampus, "suspended", "a", "d", {2, 2, 0});
  suspended.point.use = graph::LinkPointUse::kSuspended;
  const storage::GraphChanges changes =
      Changes({candidate, MakeDoor(kCampus, "door", "a", "b", {5, 0, 0}), hall, suspended});
  const graph::GraphSnapshot graph = Snapshot(changes);
  const SiteGraph before(graph, PlacedLinkPoints().With({}, graph, changes));
  ASSERT_OK_AND_ASSIGN(graph::SolvedGraph solution, graph::OptimizeGraph(graph));
  solution.switched_off = {};
  ASSERT_OK_AND_ASSIGN(graph::GraphSnapshot solved, graph::Apply(graph, graph::ChangesOf(graph, solution, 9)));
  const storage::GraphSolution stored = ToStored(before, graph::WorldPoses(solved), solution);
  EXPECT_EQ(stored.residual_count, 1 + 3) << "one of the door, one per anchor of the hall";
  std::vector<std::string> maps;
  for (const storage::MapPose& pose : stored.maps) maps.push_back(pose.map.value());
  EXPECT_THAT(maps, ElementsAre("a", "b", "c")) << "by id; d is not joined to the root";
  // Candidates and suspended link points have a place, too, if a map of theirs has one.
  std::vector<std::string> placed;
  for (const storage::LinkPointPose& pose : stored.link_points) placed.push_back(pose.link_point.value());
  EXPECT_THAT(placed, ::testing::UnorderedElementsAre("candidate", "door", "hall", "suspended"));
  EXPECT_EQ(stored.chi2_after, solution.chi2_after);
}

}  // namespace
}  // namespace enfilade::server
