// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/graph_store.h"

#include <atomic>
#include <thread>

#include "fmt/format.h"
#include "tests/contract/storage/suite/contract_test.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class GraphStoreTest : public StoreContractTest {
 protected:
  GraphStoreTest() { EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("lab"), "Lab"), "")); }

  void Create(const std::string& id, const std::vector<graph::Anchor>& anchors) {
    ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, id, anchors), ""));
  }
  storage::GraphChanges Read(std::int64_t since) {
    auto changes = graph_.ReadChanges(Soon(), site_, since);
    EXPECT_OK(changes);
    return *std::move(changes);
  }
};

TEST_F(GraphStoreTest, TheFirstMapIsTheRootAndCarriesTheWorldFrame) {
  const storage::GraphChanges graph = Read(0);
  EXPECT_TRUE(graph.complete);
  EXPECT_EQ(graph.root, map_);
  EXPECT_EQ(graph.version, 2);
  ASSERT_THAT(graph.maps, SizeIs(2));
  ASSERT_TRUE(graph.maps[0].T_world_map);
  EXPECT_EQ(graph.maps[0].T_world_map->pose, Pose2());
  EXPECT_FALSE(graph.maps[1].T_world_map);
  backend_->AddSite(SiteId("empty"));
  ASSERT_OK_AND_ASSIGN(const storage::GraphChanges empty, graph_.ReadChanges(Soon(), SiteId("empty"), 0));
  EXPECT_EQ(empty.version, 0);
  EXPECT_TRUE(empty.root.empty());
  EXPECT_CODE(graph_.ReadChanges(Soon(), SiteId("nowhere"), 0), absl::StatusCode::kNotFound);
}

TEST_F(GraphStoreTest, GivesWhatHasChangedSinceAVersion) {
  Create("door", {MakeAnchor("hall", 1, 0), MakeAnchor("lab", 0, 0)});
  Create("gone", {MakeAnchor("hall", 5, 0)});
  const std::int64_t before = Read(0).version;
  EXPECT_THAT(Read(before).link_points, IsEmpty());
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("gone"), 0));
  ASSERT_OK(link_points_.SetSuspended(Soon(), site_, LinkPointId("door"), 0, true));
  ASSERT_OK_AND_ASSIGN(storage::Map lab, maps_.Get(Soon(), site_, MapId("lab")));
  lab.level = 4;
  lab.outline = {{0, 0}, {1, 0}, {1, 1}};
  ASSERT_OK(maps_.Update(Soon(), lab));
  const storage::GraphChanges changes = Read(before);
  EXPECT_FALSE(changes.complete);
  EXPECT_EQ(changes.version, before + 3);
  EXPECT_THAT(changes.removed_link_points, ElementsAre(LinkPointId("gone")));
  ASSERT_THAT(changes.link_points, SizeIs(1));
  EXPECT_EQ(changes.link_points[0].point.use, graph::LinkPointUse::kSuspended);
  ASSERT_THAT(changes.maps, SizeIs(1));
  EXPECT_EQ(changes.maps[0].level, 4);
  EXPECT_EQ(changes.maps[0].outline, lab.outline);
  // A version that the site never had: it was made again since.
  EXPECT_TRUE(Read(before + 100).complete);
}

TEST_F(GraphStoreTest, AGraphIsSolvedAtRestWhileEditorsWaitAndReadersDoNot) {
  Create("door", {MakeAnchor("hall", 1, 0), MakeAnchor("lab", 0, 0)});
  const std::int64_t since = Read(0).version;
  Create("later", {MakeAnchor("hall", 9, 0), MakeAnchor("lab", 1, 0)});
  std::thread editor;
  std::atomic<bool> edited{false};
  const auto solve = [&](const storage::GraphChanges& changes) -> absl::StatusOr<storage::GraphSolution> {
    EXPECT_EQ(changes.version, since + 1);
    EXPECT_THAT(changes.link_points, SizeIs(1));
    editor = std::thread([&] {
      Create("waits", {MakeAnchor("hall", 5, 0), MakeAnchor("lab", 2, 0)});
      edited = true;
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    EXPECT_EQ(Read(0).version, changes.version);
    EXPECT_FALSE(edited);
    storage::GraphSolution solution;
    solution.maps = {{MapId("lab"), {{1.5, 0.5, 0.25}, Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal()}}};
    return solution;
  };
  const auto solved = graph_.SolveHeld(Soon(), site_, since, solve);
  editor.join();
  ASSERT_OK(solved);
  EXPECT_EQ(*solved, since + 2);
  EXPECT_EQ(Read(0).version, since + 3);
  EXPECT_EQ(*graph_.FindLastOptimization(Soon(), site_, since), *solved);

  const auto fail = [](const storage::GraphChanges&) {
    return absl::StatusOr<storage::GraphSolution>(absl::InternalError("no"));
  };
  EXPECT_CODE(graph_.SolveHeld(Soon(), site_, since, fail), absl::StatusCode::kInternal);
  EXPECT_EQ(Read(0).version, since + 3);
  EXPECT_CODE(graph_.SolveHeld(Soon(), SiteId("nowhere"), 0, fail), absl::StatusCode::kNotFound);
}

TEST_F(GraphStoreTest, ASolutionIsStoredOnlyAtTheVersionThatItWasMadeFrom) {
  Create("door", {MakeAnchor("hall", 1, 0), MakeAnchor("lab", 0, 0)});
  Create("bad", {MakeAnchor("hall", 9, 0), MakeAnchor("lab", 1, 0)});
  const std::int64_t version = Read(0).version;
  storage::GraphSolution solution;
  solution.maps = {{MapId("lab"), {{1.5, 0.5, 0.25}, Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal()}}};
  solution.link_points = {{LinkPointId("door"), {{1.25, 0.5, 0.1}, Eigen::Vector3d(0.4, 0.5, 0.6).asDiagonal()}}};
  solution.switched_off = {LinkPointId("bad")};
  solution.chi2_before = 100.0;
  solution.chi2_after = 2.5;
  solution.residual_count = 2;
  EXPECT_CODE(graph_.Apply(Soon(), site_, version - 1, solution), absl::StatusCode::kAborted);
  ASSERT_OK_AND_ASSIGN(const std::int64_t applied, graph_.Apply(Soon(), site_, version, solution));
  EXPECT_EQ(applied, version + 1);
  const storage::GraphChanges changes = Read(version);
  ASSERT_THAT(changes.maps, SizeIs(1));
  EXPECT_EQ(changes.maps[0].T_world_map->pose, solution.maps[0].T_world_map.pose);
  EXPECT_EQ(changes.maps[0].T_world_map->covariance, solution.maps[0].T_world_map.covariance);
  ASSERT_THAT(changes.link_points, SizeIs(2));
  EXPECT_EQ(changes.link_points[0].point.use, graph::LinkPointUse::kSwitchedOff);
  EXPECT_EQ(changes.link_points[1].T_world_place->pose, solution.link_points[0].T_world_place.pose);
  EXPECT_EQ(changes.link_points[1].T_world_place->covariance, solution.link_points[0].T_world_place.covariance);

  ASSERT_OK_AND_ASSIGN(const auto poses, graph_.GetMapPoses(Soon(), site_, applied, 0));
  ASSERT_THAT(poses.posed, SizeIs(1));
  EXPECT_EQ(poses.posed[0].T_world_map.pose, solution.maps[0].T_world_map.pose);
  EXPECT_CODE(graph_.GetMapPoses(Soon(), site_, version, 0), absl::StatusCode::kNotFound);
  EXPECT_EQ(*graph_.FindLastOptimization(Soon(), site_, version), applied);
  EXPECT_EQ(*graph_.FindLastOptimization(Soon(), site_, applied), 0);
  ASSERT_OK_AND_ASSIGN(const auto versions, graph_.ListVersions(Soon(), site_, 0, 2));
  ASSERT_TRUE(versions[0].optimization);
  EXPECT_EQ(versions[0].optimization->chi2_after, 2.5);
  EXPECT_THAT(versions[0].optimization->switched_off, ElementsAre(LinkPointId("bad")));
  EXPECT_FALSE(versions[1].optimization);

  solution.switched_off.clear();
  ASSERT_OK(graph_.Apply(Soon(), site_, applied, solution));
  ASSERT_OK_AND_ASSIGN(const auto bad, link_points_.Get(Soon(), site_, LinkPointId("bad")));
  EXPECT_EQ(bad.point.use, graph::LinkPointUse::kUsed);
}

TEST_F(GraphStoreTest, KeepsThePosesOfTheLastOptimisationsOnly) {
  storage::GraphSolution solution;
  solution.maps = {{MapId("lab"), {{1, 2, 3}, Eigen::Matrix3d::Identity()}}};
  std::int64_t version = Read(0).version;
  const std::int64_t first = version + 1;
  for (int i = 0; i <= storage::GraphStore::kKeptOptimizations; ++i) {
    ASSERT_OK_AND_ASSIGN(version, graph_.Apply(Soon(), site_, version, solution));
  }
  EXPECT_CODE(graph_.GetMapPoses(Soon(), site_, first, 0), absl::StatusCode::kNotFound);
  EXPECT_OK(graph_.GetMapPoses(Soon(), site_, first + 1, 0));
  EXPECT_OK(graph_.GetMapPoses(Soon(), site_, version, 0));
}

TEST_F(GraphStoreTest, ASolutionThatListsItsChangesKeepsTheOtherPoses) {
  const auto pose = [](const char* map, double x) {
    return storage::MapPose{MapId(map), {{x, 0, 0}, Eigen::Matrix3d::Identity()}};
  };
  const auto apply = [&](storage::GraphSolution solution) {
    const auto applied = graph_.Apply(Soon(), site_, Read(0).version, solution);
    EXPECT_OK(applied);
    return applied.value_or(0);
  };
  const auto poses = [&](std::int64_t version, std::int64_t since) {
    const auto changes = graph_.GetMapPoses(Soon(), site_, version, since);
    EXPECT_OK(changes);
    std::vector<std::string> text;
    for (const storage::MapPose& one : changes->posed) {
      text.push_back(one.map.value() + " " + std::to_string(static_cast<int>(one.T_world_map.pose.x)));
    }
    for (const MapId& map : changes->unposed) text.push_back("no " + map.value());
    return text;
  };
  const std::int64_t first = apply({.maps = {pose("hall", 0), pose("lab", 1)}});
  const std::int64_t second = apply({.complete = false, .maps = {pose("lab", 2)}});
  const std::int64_t third = apply({.complete = false, .unposed = {MapId("hall")}});
  const std::int64_t fourth = apply({.maps = {pose("hall", 4)}});
  EXPECT_THAT(poses(first, 0), ElementsAre("hall 0", "lab 1"));
  EXPECT_THAT(poses(second, 0), ElementsAre("hall 0", "lab 2"));
  EXPECT_THAT(poses(second, first), ElementsAre("lab 2"));
  EXPECT_THAT(poses(third, 0), ElementsAre("lab 2"));
  EXPECT_THAT(poses(third, second), ElementsAre("no hall"));
  EXPECT_THAT(poses(third, first), ElementsAre("lab 2", "no hall"));
  EXPECT_THAT(poses(fourth, 0), ElementsAre("hall 4")) << "a complete one lists all that it poses";
  EXPECT_THAT(poses(fourth, third), ElementsAre("hall 4", "no lab"));

  // What a later change has replaced is forgotten, and nothing else.
  std::int64_t version = fourth;
  for (int i = 0; i < storage::GraphStore::kKeptOptimizations; ++i) {
    version = apply({.complete = false, .maps = {pose("lab", 5 + i)}});
  }
  EXPECT_CODE(graph_.GetMapPoses(Soon(), site_, fourth, 0), absl::StatusCode::kNotFound);
  EXPECT_THAT(poses(fourth + 1, 0), ElementsAre("hall 4", "lab 5"));
  EXPECT_THAT(poses(version, 0), ElementsAre("hall 4", "lab 54"));
}

TEST_F(GraphStoreTest, AReaderSeesOneVersionWhateverIsWrittenMeanwhile) {
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (int i = 0; i < 60; ++i) {
      const std::string id = fmt::format("p{}", i);
      EXPECT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, id, {MakeAnchor("hall", i, 0)}), ""));
    }
    done = true;
  });
  const std::int64_t first = 2;  // of the two maps
  while (!done) {
    const storage::GraphChanges graph = Read(0);
    EXPECT_EQ(graph.link_points.size(), static_cast<std::size_t>(graph.version - first));
  }
  writer.join();
  EXPECT_THAT(Read(0).link_points, SizeIs(60));
}

TEST_F(GraphStoreTest, ControlPointsAreReplacedAsAWhole) {
  const std::vector<storage::ControlPoint> points = {{map_, {1.5, 2.5}, 52.1, 9.7}, {MapId("lab"), {0, 0}, -90, 180}};
  const std::int64_t version = Read(0).version;
  ASSERT_OK_AND_ASSIGN(const std::int64_t raised, graph_.SetControlPoints(Soon(), site_, points));
  EXPECT_EQ(raised, version + 1);
  EXPECT_CODE(graph_.SetControlPoints(Soon(), site_, {{MapId("cellar"), {0, 0}, 0, 0}}), absl::StatusCode::kNotFound);
  EXPECT_CODE(graph_.SetControlPoints(Soon(), site_, {{map_, {0, 0}, 90.5, 0}}), absl::StatusCode::kInvalidArgument);
  ASSERT_OK_AND_ASSIGN(const auto stored, graph_.GetControlPoints(Soon(), site_));
  ASSERT_THAT(stored, SizeIs(2));
  EXPECT_EQ(stored[0].position, points[0].position);
  EXPECT_EQ(stored[1].map, MapId("lab"));
  EXPECT_EQ(stored[1].longitude, 180.0);
  EXPECT_EQ(Read(0).version, raised);
}

TEST_F(GraphStoreTest, ListsVersionsInPagesWithWhoMadeThem) {
  storage::CallContext ann = Soon();
  ann.actor = "ann";
  ASSERT_OK(link_points_.Create(ann, MakeLinkPoint(site_, "door", {MakeAnchor("hall", 1, 0)}), ""));
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("door"), 0));
  ASSERT_OK(graph_.SetControlPoints(ann, site_, {}));
  std::vector<storage::GraphVersion> listed;
  std::int64_t before = 0;
  while (true) {
    ASSERT_OK_AND_ASSIGN(const auto page, graph_.ListVersions(Soon(), site_, before, 2));
    if (page.empty()) break;
    listed.insert(listed.end(), page.begin(), page.end());
    before = page.back().version;
  }
  struct Case {
    storage::GraphCause cause;
    std::string resource;
    std::string actor;
  };
  const std::vector<Case> expected = {{storage::GraphCause::kGeoreferenced, "", "ann"},
                                      {storage::GraphCause::kLinkPointRemoved, "linkPoints/door", ""},
                                      {storage::GraphCause::kLinkPointAdded, "linkPoints/door", "ann"},
                                      {storage::GraphCause::kMapAdded, "maps/lab", ""},
                                      {storage::GraphCause::kMapAdded, "maps/hall", ""}};
  ASSERT_THAT(listed, SizeIs(expected.size()));
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(listed[i].version, static_cast<std::int64_t>(expected.size() - i));
    EXPECT_EQ(listed[i].cause, expected[i].cause) << i;
    EXPECT_EQ(listed[i].resource, expected[i].resource) << i;
    EXPECT_EQ(listed[i].actor, expected[i].actor) << i;
    EXPECT_FALSE(listed[i].optimization);
    EXPECT_GT(listed[i].create_time, 0);
  }
  ASSERT_OK_AND_ASSIGN(const auto none, graph_.ListVersions(Soon(), SiteId("nowhere"), 0, 10));
  EXPECT_THAT(none, IsEmpty());
}

TEST_F(GraphStoreTest, WhatWasRemovedAndMadeAgainComesAsBoth) {
  Create("door", {MakeAnchor("hall", 1, 0)});
  const std::int64_t since = Read(0).version;
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("door"), 0));
  Create("door", {MakeAnchor("lab", 7, 0)});
  ASSERT_OK(maps_.Delete(Soon(), site_, MapId("lab"), 0, true));
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("lab"), "Lab"), ""));
  const storage::GraphChanges changes = Read(since);
  EXPECT_THAT(changes.removed_maps, ElementsAre(MapId("lab")));
  EXPECT_THAT(changes.removed_link_points, ElementsAre(LinkPointId("door")));
  ASSERT_THAT(changes.maps, SizeIs(1));
  EXPECT_EQ(changes.maps[0].id, MapId("lab"));
  EXPECT_THAT(changes.link_points, IsEmpty()) << "it went with the lab";
  EXPECT_EQ(Read(changes.version).maps.size(), 0U);
}

TEST_F(GraphStoreTest, PlacesAreThoseOfTheMapsThatAreAskedFor) {
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("yard"), "Yard"), ""));
  Create("door", {MakeAnchor("hall", 1, 0), MakeAnchor("lab", 0, 0)});
  const auto places_of = [&](const std::vector<MapId>& maps) {
    const auto places = graph_.GetPlaces(Soon(), site_, maps);
    EXPECT_OK(places);
    std::vector<std::string> ids;
    for (const storage::MapPose& place : *places) ids.push_back(place.map.value());
    return ids;
  };
  EXPECT_THAT(places_of({}), ElementsAre("hall", "lab")) << "the yard is joined to nothing";
  EXPECT_THAT(places_of({MapId("lab"), MapId("yard"), MapId("cellar")}), ElementsAre("lab"));
  EXPECT_THAT(places_of({MapId("yard")}), IsEmpty());
}

TEST_F(GraphStoreTest, ASolutionLeavesAloneWhatItDoesNotName) {
  Create("door", {MakeAnchor("hall", 1, 0), MakeAnchor("lab", 0, 0)});
  Create("suspended", {MakeAnchor("hall", 5, 0), MakeAnchor("lab", 0, 5)});
  ASSERT_OK(link_points_.SetSuspended(Soon(), site_, LinkPointId("suspended"), 0, true));
  const storage::GraphChanges before = Read(0);
  storage::GraphSolution solution;
  solution.maps = {{MapId("gone"), {{9, 9, 9}, Eigen::Matrix3d::Identity()}}};
  solution.link_points = {{LinkPointId("gone"), {{9, 9, 9}, Eigen::Matrix3d::Identity()}}};
  solution.switched_off = {LinkPointId("suspended"), LinkPointId("gone")};
  ASSERT_OK_AND_ASSIGN(const std::int64_t version, graph_.Apply(Soon(), site_, before.version, solution));
  const storage::GraphChanges changes = Read(before.version);
  EXPECT_EQ(changes.version, version);
  EXPECT_THAT(changes.maps, IsEmpty());
  EXPECT_THAT(changes.link_points, IsEmpty()) << "what a person has suspended stays so";
  EXPECT_CODE(graph_.GetMapPoses(Soon(), site_, version, 0), absl::StatusCode::kNotFound) << "no map of it is there";
}

TEST_F(GraphStoreTest, OnlyAGraphCanBeSolved) {
  backend_->AddSite(SiteId("empty"));
  for (const char* site : {"empty", "nowhere"}) {
    EXPECT_CODE(graph_.Apply(Soon(), SiteId(site), 0, {}), absl::StatusCode::kNotFound);
    EXPECT_EQ(*graph_.GetVersion(Soon(), SiteId(site)), 0);
    EXPECT_EQ(*graph_.FindLastOptimization(Soon(), SiteId(site), 0), 0);
    ASSERT_OK_AND_ASSIGN(const auto points, graph_.GetControlPoints(Soon(), SiteId(site)));
    EXPECT_THAT(points, IsEmpty());
  }
  EXPECT_CODE(graph_.SetControlPoints(Soon(), SiteId("nowhere"), {}), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::testing
