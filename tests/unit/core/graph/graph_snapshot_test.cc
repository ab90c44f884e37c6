// SPDX-License-Identifier: Apache-2.0
#include "core/graph/graph_snapshot.h"

#include <gmock/gmock.h>

#include <map>

#include "tests/support/status_assertions.h"
#include "tests/unit/core/graph/scene.h"

namespace enfilade::graph {
namespace {

using testing::AnchorIn;
using ::testing::ElementsAre;
using testing::Graph;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsNull;
using testing::Joining;
using testing::L;
using testing::M;
using testing::MapNamed;
using ::testing::NotNull;
using testing::Numbered;
using ::testing::SizeIs;

std::vector<std::string> DoorwaysOf(const GraphSnapshot& graph, const std::string& map) {
  std::vector<std::string> ids;
  for (const GraphSnapshot::Doorway& doorway : graph.map_node(graph.MapSlot(M(map))).doorways) {
    ids.push_back(graph.link_point_node(doorway.link_point).link_point->id.value());
  }
  return ids;
}

TEST(GraphSnapshotTest, StartsEmpty) {
  const GraphSnapshot graph;
  EXPECT_TRUE(graph.root().empty());
  EXPECT_THAT(graph.FindMap(M("a")), IsNull());
  EXPECT_THAT(graph.FindLinkPoint(L("a")), IsNull());
  EXPECT_THAT(graph.ListMaps(), IsEmpty());
}

TEST(GraphSnapshotTest, KnowsWhichLinkPointsJoinWhichMaps) {
  const GraphSnapshot graph = Graph({"a", "b"}, {Joining("door", {AnchorIn("a", {1, 2, 0}), AnchorIn("b", {})}),
                                                 Joining("candidate", {AnchorIn("a", {3, 0, 0})})});
  EXPECT_EQ(graph.root(), M("a"));
  EXPECT_THAT(DoorwaysOf(graph, "a"), ElementsAre("door"));
  EXPECT_THAT(DoorwaysOf(graph, "b"), ElementsAre("door"));
  EXPECT_THAT(graph.map_node(graph.MapSlot(M("a"))).link_points, SizeIs(2));
}

TEST(GraphSnapshotTest, ASecondAnchorMakesACandidateALinkPoint) {
  const GraphSnapshot before = Graph({"a", "b"}, {Joining("x", {AnchorIn("a", {})})});
  const GraphSnapshot after = Graph({}, {Joining("x", {AnchorIn("a", {}), AnchorIn("b", {})})}, before);
  EXPECT_THAT(DoorwaysOf(before, "b"), IsEmpty());
  EXPECT_THAT(DoorwaysOf(after, "b"), ElementsAre("x"));
  EXPECT_EQ(after.link_point_count(), 1u);
}

TEST(GraphSnapshotTest, SuspendedAndSwitchedOffLinkPointsAreNotUsed) {
  LinkPoint suspended = Joining("s", {AnchorIn("a", {}), AnchorIn("b", {})});
  suspended.use = LinkPointUse::kSuspended;
  LinkPoint off = Joining("o", {AnchorIn("a", {}), AnchorIn("b", {})});
  off.use = LinkPointUse::kSwitchedOff;
  const GraphSnapshot graph = Graph({"a", "b"}, {suspended, off});
  EXPECT_THAT(DoorwaysOf(graph, "a"), IsEmpty());
  suspended.use = LinkPointUse::kUsed;
  EXPECT_THAT(DoorwaysOf(Graph({}, {suspended}, graph), "a"), ElementsAre("s"));
}

TEST(GraphSnapshotTest, AnOlderVersionStaysUnchanged) {
  const GraphSnapshot old = Graph({"a", "b"}, {Joining("x", {AnchorIn("a", {}), AnchorIn("b", {})})});
  SnapshotChanges changes{.version = 7, .removed_link_points = {L("x")}, .removed_maps = {M("b")}};
  const GraphSnapshot next = Apply(old, changes).value();
  EXPECT_EQ(next.version(), 7);
  EXPECT_THAT(next.FindMap(M("b")), IsNull());
  EXPECT_THAT(next.FindLinkPoint(L("x")), IsNull());
  EXPECT_EQ(old.version(), 1);
  EXPECT_THAT(old.FindMap(M("b")), NotNull());
  EXPECT_THAT(DoorwaysOf(old, "b"), ElementsAre("x"));
}

TEST(GraphSnapshotTest, RefusesAnAnchorInNoMapAndTheRemovalOfAMapInUse) {
  const GraphSnapshot graph = Graph({"a", "b"}, {Joining("x", {AnchorIn("a", {}), AnchorIn("b", {})})});
  EXPECT_STATUS(Apply(graph, {.version = 2, .link_points = {Joining("y", {AnchorIn("z", {})})}}),
                absl::StatusCode::kInvalidArgument, HasSubstr("map z"));
  EXPECT_STATUS(Apply(graph, {.version = 2, .removed_maps = {M("a")}}), absl::StatusCode::kFailedPrecondition,
                HasSubstr("x"));
}

TEST(GraphSnapshotTest, RefusesInvalidLinkPoints) {
  Eigen::Matrix3d indefinite = Eigen::Matrix3d::Identity();
  indefinite(0, 1) = indefinite(1, 0) = 2.0;
  Eigen::Matrix3d skewed = Eigen::Matrix3d::Identity();
  skewed(0, 1) = 0.5;
  const std::vector<LinkPoint> invalid = {
      Joining("", {AnchorIn("a", {})}),
      Joining("none", {}),
      Joining("twice", {AnchorIn("a", {}), AnchorIn("a", {})}),
      Joining("nan", {AnchorIn("a", {std::nan(""), 0, 0})}),
      Joining("nan", {AnchorIn("a", {}, Eigen::Matrix3d::Constant(std::nan("")))}),
      Joining("indefinite", {AnchorIn("a", {}, indefinite)}),
      Joining("skewed", {AnchorIn("a", {}, skewed)}),
  };
  for (const LinkPoint& link_point : invalid) {
    EXPECT_CODE(Apply(Graph({"a"}, {}), {.version = 2, .link_points = {link_point}}),
                absl::StatusCode::kInvalidArgument)
        << link_point.id.value();
  }
}

// Ids generated from counts would collide after a deletion.
TEST(GraphSnapshotTest, IdsAreArbitraryAndCanBeReusedAfterRemoval) {
  GraphSnapshot graph = Graph({"100", "101", "7"}, {Joining("100", {AnchorIn("100", {}), AnchorIn("7", {})}),
                                                    Joining("101", {AnchorIn("101", {}), AnchorIn("7", {})})});
  graph = Apply(graph, {.version = 2, .removed_link_points = {L("100")}, .removed_maps = {M("100")}}).value();
  graph = Graph({"0"}, {Joining("3", {AnchorIn("0", {}), AnchorIn("7", {})})}, graph);
  graph = Graph({"100"}, {Joining("100", {AnchorIn("100", {}), AnchorIn("7", {})})}, graph);
  EXPECT_THAT(DoorwaysOf(graph, "7"), ElementsAre("100", "101", "3"));
  EXPECT_THAT(DoorwaysOf(graph, "0"), ElementsAre("3"));
  EXPECT_THAT(DoorwaysOf(graph, "101"), ElementsAre("101"));
}

TEST(GraphSnapshotTest, RandomChangesGiveTheSameAsBuildingTheResultDirectly) {
  std::mt19937_64 random(1);
  const auto pick = [&random](int n) { return static_cast<int>(random() % static_cast<std::uint64_t>(n)); };
  std::map<MapId, MapInGraph> maps;
  std::map<LinkPointId, LinkPoint> link_points;
  GraphSnapshot graph = Graph({"m0"}, {});
  maps[M("m0")] = MapNamed("m0");
  for (int step = 0; step < 3000; ++step) {
    SnapshotChanges changes{.version = graph.version() + 1};
    const std::string map = Numbered("m", pick(300));
    const std::string link_point = Numbered("l", pick(500));
    switch (pick(4)) {
      case 0:
        changes.maps.push_back(MapNamed(map, pick(5)));
        break;
      case 1:
        changes.removed_link_points.push_back(L(link_point));
        break;
      case 2: {
        std::vector<Anchor> anchors;
        for (const auto& [id, m] : maps) {
          if (anchors.size() < 3 && pick(static_cast<int>(maps.size())) < 3) {
            anchors.push_back(AnchorIn(id.value(), {static_cast<double>(pick(9)), 0, 0}));
          }
        }
        if (!anchors.empty()) changes.link_points.push_back(Joining(link_point, anchors));
        break;
      }
      default:
        if (map == "m0") break;
        for (const auto& [id, value] : link_points) {
          if (value.FindAnchor(M(map)) != nullptr) changes.removed_link_points.push_back(id);
        }
        changes.removed_maps.push_back(M(map));
    }
    for (const MapInGraph& m : changes.maps) maps[m.id] = m;
    for (const LinkPointId& id : changes.removed_link_points) link_points.erase(id);
    for (const LinkPoint& l : changes.link_points) link_points[l.id] = l;
    for (const MapId& id : changes.removed_maps) maps.erase(id);
    auto next = Apply(graph, changes);
    ASSERT_TRUE(next.ok()) << next.status();
    graph = *std::move(next);
  }
  ASSERT_EQ(graph.map_count(), maps.size());
  ASSERT_EQ(graph.link_point_count(), link_points.size());
  std::map<std::string, std::vector<std::string>> doorways;
  for (const auto& [id, value] : link_points) {
    ASSERT_THAT(graph.FindLinkPoint(id), NotNull());
    EXPECT_EQ(*graph.FindLinkPoint(id), value);
    if (value.is_candidate()) continue;
    for (const Anchor& anchor : value.anchors) doorways[anchor.map.value()].push_back(id.value());
  }
  for (const auto& [id, value] : maps) {
    ASSERT_THAT(graph.FindMap(id), NotNull());
    EXPECT_EQ(*graph.FindMap(id), value);
    EXPECT_EQ(DoorwaysOf(graph, id.value()), doorways[id.value()]) << id.value();
  }
}

}  // namespace
}  // namespace enfilade::graph
