// SPDX-License-Identifier: Apache-2.0
// Several changes of link points in one transaction.
#include <string>
#include <vector>

#include "storage/graph/link_point_store.h"
#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

// Link points "door" and "gate" between "hall" and "lab".
class LinkPointChangeTest : public StoreContractTest {
 protected:
  LinkPointChangeTest() {
    EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("lab"), "lab"), ""));
    for (const auto& [id, x] : {std::pair("door", 0.0), std::pair("gate", 10.0)}) {
      EXPECT_OK(link_points_.Create(Soon(),
                                    MakeLinkPoint(site_, id, {MakeAnchor("hall", x, 0), MakeAnchor("lab", x, 0)}), ""));
    }
  }

  storage::StoredLinkPoint Get(const std::string& id) {
    auto stored = link_points_.Get(Soon(), site_, LinkPointId(id));
    EXPECT_OK(stored);
    return stored.value_or(storage::StoredLinkPoint());
  }
  storage::LinkPointUpdate Move(const std::string& id, double to_x) {
    storage::LinkPointUpdate update{Get(id)};
    for (graph::Anchor& anchor : update.link_point.point.anchors) anchor.T_map_place.x = to_x;
    return update;
  }
  absl::StatusOr<storage::ChangedLinkPoints> Change(const std::vector<storage::LinkPointChange>& changes) {
    return link_points_.Change(Soon(), site_, changes);
  }
  // All that readers see of the graph.
  storage::GraphChanges WholeGraph() {
    auto changes = graph_.ReadChanges(Soon(), site_, 0);
    EXPECT_OK(changes);
    return changes.value_or(storage::GraphChanges());
  }
};

TEST_F(LinkPointChangeTest, MakesAllChangesInTheirOrder) {
  const std::int64_t before = WholeGraph().version;
  storage::LinkPointCreation creation{MakeLinkPoint(site_, "lift", {MakeAnchor("hall", 20, 0)})};
  ASSERT_OK_AND_ASSIGN(const storage::ChangedLinkPoints changed,
                       Change({creation, Move("gate", 12), storage::LinkPointSuspension{LinkPointId("gate"), 0, true},
                               storage::LinkPointDeletion{LinkPointId("door"), Get("door").etag}}));
  EXPECT_EQ(changed.graph_version, before + 4);
  ASSERT_THAT(changed.link_points, SizeIs(2));
  EXPECT_EQ(changed.link_points[0].point.id, LinkPointId("lift"));
  EXPECT_EQ(changed.link_points[1].point.use, graph::LinkPointUse::kSuspended);
  EXPECT_EQ(changed.link_points[1].point.anchors[1].T_map_place.x, 12.0);
  EXPECT_EQ(changed.link_points[1].etag, Get("gate").etag);
  EXPECT_EQ(changed.link_points[1].point.graph_version, before + 3);
  EXPECT_CODE(link_points_.Get(Soon(), site_, LinkPointId("door")), absl::StatusCode::kNotFound);
  ASSERT_OK_AND_ASSIGN(const auto versions, graph_.ListVersions(Soon(), site_, 0, 4));
  std::vector<std::string> resources;
  for (const storage::GraphVersion& version : versions) resources.push_back(version.resource);
  EXPECT_THAT(resources, ElementsAre("linkPoints/door", "linkPoints/gate", "linkPoints/gate", "linkPoints/lift"));
  ASSERT_OK_AND_ASSIGN(const auto since, graph_.ReadChanges(Soon(), site_, before));
  EXPECT_THAT(since.removed_link_points, ElementsAre(LinkPointId("door")));
  EXPECT_THAT(since.link_points, SizeIs(2));
}

TEST_F(LinkPointChangeTest, WhatIsDeletedCanBeMadeAgainInOneGo) {
  ASSERT_OK_AND_ASSIGN(const storage::ChangedLinkPoints changed,
                       Change({storage::LinkPointDeletion{LinkPointId("door"), 0},
                               storage::LinkPointCreation{MakeLinkPoint(site_, "door", {MakeAnchor("lab", 3, 0)})}}));
  ASSERT_THAT(changed.link_points, SizeIs(1));
  EXPECT_TRUE(Get("door").point.is_candidate());
}

TEST_F(LinkPointChangeTest, MakesNoneIfOneIsRefused) {
  const storage::StoredLinkPoint door = Get("door");
  const storage::GraphChanges before = WholeGraph();
  const storage::LinkPointCreation creation{MakeLinkPoint(site_, "lift", {MakeAnchor("hall", 20, 0)})};
  const storage::LinkPointUpdate moved = Move("door", 5);
  storage::LinkPointUpdate stale = Move("gate", 12);
  stale.link_point.etag += 1;
  const storage::LinkPointCreation redundant{
      MakeLinkPoint(site_, "again", {MakeAnchor("hall", 10, 0), MakeAnchor("lab", 10, 0)})};
  const storage::LinkPointCreation nowhere{MakeLinkPoint(site_, "d", {MakeAnchor("cellar", 0, 0)})};
  storage::LinkPointUpdate bad = Move("gate", 0);
  bad.link_point.point.anchors.clear();
  struct Case {
    storage::LinkPointChange refused;
    absl::StatusCode code;
    std::string text;
  };
  for (const Case& one : std::vector<Case>{
           {stale, absl::StatusCode::kAborted, "linkPoints/gate"},
           {storage::LinkPointSuspension{LinkPointId("gate"), stale.link_point.etag, true}, absl::StatusCode::kAborted,
            "linkPoints/gate"},
           {storage::LinkPointDeletion{LinkPointId("none"), 0}, absl::StatusCode::kNotFound, "linkPoints/none"},
           {redundant, absl::StatusCode::kAlreadyExists, "linkPoints/gate"},
           {nowhere, absl::StatusCode::kNotFound, "cellar"},
           {bad, absl::StatusCode::kInvalidArgument, "anchors"}}) {
    EXPECT_STATUS(Change({creation, moved, storage::LinkPointDeletion{LinkPointId("lift"), 0}, creation, one.refused}),
                  one.code, AllOf(HasSubstr("changes[4]: "), HasSubstr(one.text)));
    const storage::GraphChanges after = WholeGraph();
    EXPECT_EQ(after.version, before.version);
    EXPECT_THAT(after.link_points, SizeIs(2));
    EXPECT_EQ(Get("door").point, door.point);
    EXPECT_EQ(Get("door").etag, door.etag);
  }
  EXPECT_STATUS(Change({}), absl::StatusCode::kInvalidArgument, HasSubstr("at least one"));
  EXPECT_CODE(link_points_.Change(Soon(), SiteId("nowhere"), {storage::LinkPointDeletion{LinkPointId("d"), 0}}),
              absl::StatusCode::kNotFound);
  // What was refused has left nothing behind.
  EXPECT_OK(Change({creation, moved}));
}

TEST_F(LinkPointChangeTest, OfTwoWithTheSameEtagOneIsRefused) {
  const storage::LinkPointUpdate mine = Move("gate", 11);
  const storage::LinkPointUpdate theirs = Move("gate", 12);
  const storage::LinkPointCreation creation{MakeLinkPoint(site_, "lift", {MakeAnchor("hall", 20, 0)})};
  ASSERT_OK(Change({mine}));
  EXPECT_CODE(Change({creation, theirs}), absl::StatusCode::kAborted);
  EXPECT_EQ(Get("gate").point.anchors[0].T_map_place.x, 11.0);
  EXPECT_CODE(link_points_.Get(Soon(), site_, LinkPointId("lift")), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::testing
