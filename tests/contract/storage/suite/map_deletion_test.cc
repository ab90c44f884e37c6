// SPDX-License-Identifier: Apache-2.0
#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class MapDeletionTest : public StoreContractTest {
 protected:
  MapDeletionTest() {
    for (const char* id : {"lab", "yard"}) EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, MapId(id), id), ""));
    Create("door", {MakeAnchor("hall", 1, 0), MakeAnchor("lab", 0, 0)});
    Create("candidate", {MakeAnchor("lab", 7, 0)});
    Create("lift", {MakeAnchor("hall", 3, 0), MakeAnchor("lab", 5, 0), MakeAnchor("yard", 0, 0)});
  }
  void Create(const std::string& id, const std::vector<graph::Anchor>& anchors) {
    storage::StoredLinkPoint link_point = MakeLinkPoint(site_, id, anchors);
    link_point.point.direction = anchors.front().map;
    ASSERT_OK(link_points_.Create(Soon(), link_point, ""));
  }
};

TEST_F(MapDeletionTest, ReportsWhichSessionsAndLinkPointsDependOnTheMap) {
  const SessionId session("s1");
  ASSERT_OK(sessions_.Create(Soon(), MakeSession(site_, session, robot_, MapId("lab")), ""));
  const auto version = graph_.GetVersion(Soon(), site_);
  EXPECT_STATUS(maps_.Delete(Soon(), site_, MapId("lab"), 0, false), absl::StatusCode::kFailedPrecondition,
                AllOf(HasSubstr("s1"), HasSubstr("candidate, door, lift"), HasSubstr("force")));
  EXPECT_EQ(graph_.GetVersion(Soon(), site_), version);
}

TEST_F(MapDeletionTest, ForceTakesWhatJoinsNoTwoOtherMaps) {
  ASSERT_OK_AND_ASSIGN(const std::int64_t version, graph_.GetVersion(Soon(), site_));
  ASSERT_OK(maps_.Delete(Soon(), site_, MapId("lab"), 0, true));
  ASSERT_OK_AND_ASSIGN(const storage::GraphChanges changes, graph_.ReadChanges(Soon(), site_, version));
  EXPECT_EQ(changes.version, version + 1);
  EXPECT_THAT(changes.removed_maps, ElementsAre(MapId("lab")));
  EXPECT_THAT(changes.removed_link_points, ElementsAre(LinkPointId("candidate"), LinkPointId("door")));
  ASSERT_THAT(changes.link_points, SizeIs(1));
  EXPECT_THAT(changes.link_points[0].point.anchors, SizeIs(2));
  EXPECT_EQ(changes.link_points[0].point.direction, map_);
}

TEST_F(MapDeletionTest, TheOldestOfTheOthersCarriesTheWorldFrameOn) {
  ASSERT_OK_AND_ASSIGN(const auto before, graph_.GetPlaces(Soon(), site_, {MapId("lab")}));
  ASSERT_OK(maps_.Delete(Soon(), site_, map_, 0, true));
  ASSERT_OK_AND_ASSIGN(const storage::GraphChanges graph, graph_.ReadChanges(Soon(), site_, 0));
  EXPECT_EQ(graph.root, MapId("lab"));
  ASSERT_OK_AND_ASSIGN(const auto after, graph_.GetPlaces(Soon(), site_, {MapId("lab")}));
  EXPECT_EQ(after[0].T_world_map.pose, before[0].T_world_map.pose);
  ASSERT_OK(maps_.Delete(Soon(), site_, MapId("lab"), 0, true));
  ASSERT_OK(maps_.Delete(Soon(), site_, MapId("yard"), 0, true));
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("new"), "new"), ""));
  ASSERT_OK_AND_ASSIGN(const storage::GraphChanges anew, graph_.ReadChanges(Soon(), site_, 0));
  EXPECT_EQ(anew.root, MapId("new"));
  EXPECT_GT(anew.version, graph.version);
}

}  // namespace
}  // namespace enfilade::testing
