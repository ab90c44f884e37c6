// SPDX-License-Identifier: Apache-2.0
#include "storage/link_point_store.h"

#include <cmath>
#include <limits>

#include "core/base/environment.h"
#include "storage/maintenance.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Maps "hall" (the root), "lab" and "yard", each on a level of its own where `levels` says so.
class LinkPointStoreTest : public StoreTest {
 protected:
  LinkPointStoreTest() {
    for (const char* id : {"lab", "yard"}) EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, MapId(id), id), ""));
  }

  absl::StatusOr<storage::StoredLinkPoint> Create(const std::string& id, const std::vector<graph::Anchor>& anchors,
                                                  bool forced = false) {
    storage::StoredLinkPoint link_point = MakeLinkPoint(site_, id, anchors);
    link_point.forced = forced;
    return link_points_.Create(Soon(), link_point, "");
  }
  absl::StatusOr<storage::StoredLinkPoint> Get(const std::string& id) {
    return link_points_.Get(Soon(), site_, LinkPointId(id));
  }
  std::int64_t Version() {
    const auto version = graph_.GetVersion(Soon(), site_);
    EXPECT_OK(version);
    return version.value_or(-1);
  }
};

TEST_F(LinkPointStoreTest, GivesBackWhatWasStored) {
  storage::StoredLinkPoint lift = MakeLinkPoint(
      site_, "lift",
      {MakeAnchor("yard", 1.5, -2.25, 3.0), MakeAnchor("hall", 5e5, 5.8e6, -1.0), MakeAnchor("lab", 0, 0)});
  lift.point.anchors[1].covariance << 0.04, 0.01, 0.002, 0.01, 0.09, -0.003, 0.002, -0.003, 0.01;
  lift.point.kind = graph::LinkPointKind::kLift;
  lift.point.tag = "Lift 'A/B' \"east\" \\ 楼层; DROP TABLE link_points; --";
  lift.point.direction = MapId("lab");
  lift.point.difficulty = 7;
  lift.point.state = graph::PassageState::kBlocked;
  lift.point.state_valid_until = 1'900'000'000 * kNsPerSecond + 5'000;
  lift.environment = Environment::kOutdoor;
  const std::int64_t before = Version();
  ASSERT_OK_AND_ASSIGN(const storage::StoredLinkPoint created, link_points_.Create(Soon(), lift, ""));
  ASSERT_OK_AND_ASSIGN(const storage::StoredLinkPoint stored, Get("lift"));
  graph::LinkPoint expected = lift.point;
  expected.graph_version = before + 1;
  EXPECT_EQ(stored.point, expected);
  EXPECT_EQ(created.point, expected);
  EXPECT_EQ(stored.environment, Environment::kOutdoor);
  EXPECT_FALSE(stored.point.is_candidate());
  EXPECT_EQ(Version(), before + 1);
}

TEST_F(LinkPointStoreTest, SaysWhatIsMissingTakenOrWrong) {
  ASSERT_OK(Create("door", {MakeAnchor("hall", 0, 0)}));
  EXPECT_STATUS(Create("door", {MakeAnchor("hall", 9, 9)}), absl::StatusCode::kAlreadyExists,
                HasSubstr("linkPoints/door exists"));
  EXPECT_STATUS(Create("d2", {MakeAnchor("hall", 0, 0), MakeAnchor("cellar", 0, 0)}), absl::StatusCode::kNotFound,
                HasSubstr("cellar"));
  EXPECT_STATUS(link_points_.Create(Soon(), MakeLinkPoint(SiteId("nowhere"), "d", {MakeAnchor("hall", 0, 0)}), ""),
                absl::StatusCode::kNotFound, HasSubstr("sites/nowhere"));
  EXPECT_STATUS(Create("d2", {}), absl::StatusCode::kInvalidArgument, HasSubstr("anchors"));
  EXPECT_STATUS(Create("d2", {MakeAnchor("hall", 0, 0), MakeAnchor("hall", 1, 0)}), absl::StatusCode::kInvalidArgument,
                HasSubstr("anchors[1]"));
  EXPECT_STATUS(Create("d2", {MakeAnchor("hall", std::nan(""), 0)}), absl::StatusCode::kInvalidArgument,
                HasSubstr("pose"));
  graph::Anchor anchor = MakeAnchor("hall", 0, 0);
  anchor.covariance(0, 1) = 1.0;
  EXPECT_STATUS(Create("d2", {anchor}), absl::StatusCode::kInvalidArgument, HasSubstr("symmetric"));
  anchor.covariance(1, 0) = 1.0;
  EXPECT_STATUS(Create("d2", {anchor}), absl::StatusCode::kInvalidArgument, HasSubstr("semi-definite"));
  EXPECT_CODE(Get("d2"), absl::StatusCode::kNotFound);
}

TEST_F(LinkPointStoreTest, CreatingIsSafeToRepeat) {
  ASSERT_OK_AND_ASSIGN(const auto first,
                       link_points_.Create(Soon(), MakeLinkPoint(site_, "a", {MakeAnchor("hall", 0, 0)}), "request"));
  const std::int64_t version = Version();
  ASSERT_OK_AND_ASSIGN(const auto again,
                       link_points_.Create(Soon(), MakeLinkPoint(site_, "b", {MakeAnchor("hall", 0, 0)}), "request"));
  EXPECT_EQ(again.point, first.point);
  EXPECT_EQ(Version(), version);
}

TEST_F(LinkPointStoreTest, ACandidateIsPromotedByItsSecondAnchor) {
  ASSERT_OK_AND_ASSIGN(const auto candidate, Create("door", {MakeAnchor("hall", 3, 4, 0.5)}));
  EXPECT_TRUE(candidate.point.is_candidate());
  EXPECT_CODE(link_points_.AddAnchor(Soon(), site_, {LinkPointId("door"), candidate.etag + 1, MakeAnchor("lab", 0, 0)}),
              absl::StatusCode::kAborted);
  ASSERT_OK_AND_ASSIGN(
      const auto promoted,
      link_points_.AddAnchor(Soon(), site_, {LinkPointId("door"), candidate.etag, MakeAnchor("lab", 1, 2)}));
  EXPECT_FALSE(promoted.point.is_candidate());
  ASSERT_THAT(promoted.point.anchors, SizeIs(2));
  EXPECT_EQ(promoted.point.anchors[1].map, MapId("lab"));
  EXPECT_STATUS(link_points_.AddAnchor(Soon(), site_, {LinkPointId("door"), 0, MakeAnchor("lab", 1, 2)}),
                absl::StatusCode::kAlreadyExists, HasSubstr("\"lab\""));
  EXPECT_CODE(link_points_.AddAnchor(Soon(), site_, {LinkPointId("gate"), 0, MakeAnchor("lab", 1, 2)}),
              absl::StatusCode::kNotFound);
}

TEST_F(LinkPointStoreTest, RefusesWhatIsRedundantUnlessForced) {
  ASSERT_OK(Create("door", {MakeAnchor("hall", 10, 0), MakeAnchor("lab", 0, 0)}));
  EXPECT_STATUS(Create("again", {MakeAnchor("lab", 0.1, 0), MakeAnchor("hall", 10.2, 0)}),
                absl::StatusCode::kAlreadyExists, AllOf(HasSubstr("linkPoints/door"), HasSubstr("0.20 m")));
  EXPECT_CODE(Get("again"), absl::StatusCode::kNotFound);
  // Two doors between the same rooms; another pair of maps; seen at the same place from one of the maps only.
  EXPECT_OK(Create("second", {MakeAnchor("hall", 12, 0), MakeAnchor("lab", 2, 0)}));
  EXPECT_OK(Create("other", {MakeAnchor("hall", 10, 0), MakeAnchor("yard", 0, 0)}));
  EXPECT_OK(Create("contradiction", {MakeAnchor("hall", 10, 0), MakeAnchor("lab", 20, 0)}));
  // What is less certain is redundant from farther away: 95 % of a difference with a sigma of 0.5 m lies within 1.22 m.
  graph::Anchor vague = MakeAnchor("hall", 11.1, 0);
  vague.covariance = Eigen::Vector3d(0.25, 0.25, 0.01).asDiagonal();
  graph::Anchor vague_lab = MakeAnchor("lab", 1.1, 0);
  vague_lab.covariance = vague.covariance;
  EXPECT_CODE(Create("vague", {vague, vague_lab}), absl::StatusCode::kAlreadyExists);
  ASSERT_OK_AND_ASSIGN(const auto forced,
                       Create("forced", {MakeAnchor("hall", 10, 0.1), MakeAnchor("lab", 0, 0)}, true));
  EXPECT_TRUE(forced.forced);
  // The one beside it may still be edited.
  ASSERT_OK_AND_ASSIGN(storage::StoredLinkPoint door, Get("door"));
  door.point.anchors[0].T_map_place.x += 0.05;
  EXPECT_OK(link_points_.Update(Soon(), door));
}

TEST_F(LinkPointStoreTest, PromotionIsCheckedForRedundancyToo) {
  ASSERT_OK(Create("door", {MakeAnchor("hall", 10, 0), MakeAnchor("lab", 0, 0)}));
  ASSERT_OK(Create("candidate", {MakeAnchor("hall", 10, 0)}));
  EXPECT_CODE(link_points_.AddAnchor(Soon(), site_, {LinkPointId("candidate"), 0, MakeAnchor("lab", 0, 0)}),
              absl::StatusCode::kAlreadyExists);
  EXPECT_OK(link_points_.AddAnchor(Soon(), site_, {LinkPointId("candidate"), 0, MakeAnchor("lab", 0, 0), true}));
}

TEST_F(LinkPointStoreTest, WhatReplacesASuspendedOneStandsBesideItAndKeepsItOut) {
  ASSERT_OK(Create("wrong", {MakeAnchor("hall", 10, 0), MakeAnchor("lab", 0, 0)}));
  ASSERT_OK_AND_ASSIGN(const auto suspended, link_points_.SetSuspended(Soon(), site_, LinkPointId("wrong"), 0, true));
  EXPECT_EQ(suspended.point.use, graph::LinkPointUse::kSuspended);
  ASSERT_OK(Create("right", {MakeAnchor("hall", 10.1, 0), MakeAnchor("lab", 0, 0)}));
  EXPECT_STATUS(link_points_.SetSuspended(Soon(), site_, LinkPointId("wrong"), suspended.etag, false),
                absl::StatusCode::kAlreadyExists, HasSubstr("right"));
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("right"), 0));
  EXPECT_OK(link_points_.SetSuspended(Soon(), site_, LinkPointId("wrong"), suspended.etag, false));
  EXPECT_CODE(link_points_.SetSuspended(Soon(), site_, LinkPointId("wrong"), suspended.etag, true),
              absl::StatusCode::kAborted);
}

TEST_F(LinkPointStoreTest, UpdatesOnlyUnderTheStoredEtag) {
  ASSERT_OK_AND_ASSIGN(storage::StoredLinkPoint door,
                       Create("door", {MakeAnchor("hall", 0, 0), MakeAnchor("lab", 0, 0)}));
  const storage::StoredLinkPoint first = door;
  door.point.tag = "new";
  door.point.anchors = {MakeAnchor("hall", 1, 0), MakeAnchor("yard", 2, 0)};
  ASSERT_OK_AND_ASSIGN(const storage::StoredLinkPoint updated, link_points_.Update(Soon(), door));
  EXPECT_EQ(updated.point.tag, "new");
  ASSERT_THAT(updated.point.anchors, SizeIs(2));
  EXPECT_EQ(updated.point.anchors[0].T_map_place.x, 1.0);
  EXPECT_EQ(updated.point.anchors[1].map, MapId("yard"));
  EXPECT_CODE(link_points_.Update(Soon(), first), absl::StatusCode::kAborted);
  EXPECT_CODE(link_points_.Delete(Soon(), site_, LinkPointId("door"), first.etag), absl::StatusCode::kAborted);
  door.point.id = LinkPointId("gate");
  EXPECT_CODE(link_points_.Update(Soon(), door), absl::StatusCode::kNotFound);
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("door"), updated.etag));
  EXPECT_CODE(link_points_.Delete(Soon(), site_, LinkPointId("door"), 0), absl::StatusCode::kNotFound);
}

TEST_F(LinkPointStoreTest, DeletedInTheMiddleAndMadeAgain) {
  for (const char* id : {"a", "b", "c"}) ASSERT_OK(Create(id, {MakeAnchor("hall", 0, 0)}));
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("b"), 0));
  ASSERT_OK(Create("b", {MakeAnchor("lab", 1, 1)}));
  ASSERT_OK(Create("d", {MakeAnchor("hall", 0, 0)}));
  ASSERT_OK_AND_ASSIGN(const auto listed, link_points_.List(Soon(), site_, {}, {}));
  std::vector<std::string> ids;
  for (const auto& link_point : listed) ids.push_back(link_point.point.id.value());
  EXPECT_THAT(ids, ElementsAre("a", "b", "c", "d"));
}

TEST_F(LinkPointStoreTest, ListsByFilterAndPage) {
  storage::StoredLinkPoint gate = MakeLinkPoint(site_, "gate", {MakeAnchor("hall", 0, 0), MakeAnchor("yard", 0, 0)});
  gate.point.kind = graph::LinkPointKind::kOpening;
  gate.point.tag = "it's";
  gate.point.state = graph::PassageState::kClosed;
  ASSERT_OK(link_points_.Create(Soon(), gate, ""));
  ASSERT_OK(Create("door", {MakeAnchor("hall", 5, 0), MakeAnchor("lab", 0, 0)}));
  ASSERT_OK(Create("maybe", {MakeAnchor("lab", 5, 0)}));
  const auto list = [&](const storage::LinkPointFilter& filter, const storage::PageRequest& page = {}) {
    const auto listed = link_points_.List(Soon(), site_, filter, page);
    EXPECT_OK(listed);
    std::vector<std::string> ids;
    for (const auto& link_point : *listed) ids.push_back(link_point.point.id.value());
    return ids;
  };
  EXPECT_THAT(list({}), ElementsAre("door", "gate", "maybe"));
  EXPECT_THAT(list({.map = MapId("lab")}), ElementsAre("door", "maybe"));
  EXPECT_THAT(list({.map = MapId("lab"), .candidate = false}), ElementsAre("door"));
  EXPECT_THAT(list({.kind = graph::LinkPointKind::kOpening}), ElementsAre("gate"));
  EXPECT_THAT(list({.state = graph::PassageState::kClosed}), ElementsAre("gate"));
  EXPECT_THAT(list({.use = graph::LinkPointUse::kSuspended}), IsEmpty());
  EXPECT_THAT(list({.candidate = true}), ElementsAre("maybe"));
  EXPECT_THAT(list({.tag = "it's"}), ElementsAre("gate"));
  EXPECT_THAT(list({}, {.limit = 2, .after = ""}), ElementsAre("door", "gate"));
  EXPECT_THAT(list({}, {.limit = 2, .after = "gate"}), ElementsAre("maybe"));
}

TEST_F(LinkPointStoreTest, EvidenceKeepsItsBlobs) {
  ASSERT_OK(Create("door", {MakeAnchor("hall", 0, 0)}));
  const TestBlob rear("rear image"), cloud("cloud"), unused("unused");
  ASSERT_OK(blobs_.Put(Soon(), site_, {rear.view(), cloud.view(), unused.view()}));
  storage::Evidence evidence{LinkPointId("door"), map_, storage::EvidenceKind::kRearImage, 1, rear.ref(), 42};
  ASSERT_OK(link_points_.PutEvidence(Soon(), site_, evidence));
  evidence.kind = storage::EvidenceKind::kCloud;
  evidence.content = unused.ref();
  ASSERT_OK(link_points_.PutEvidence(Soon(), site_, evidence));
  evidence.content = cloud.ref();
  evidence.encoding = 2;
  ASSERT_OK(link_points_.PutEvidence(Soon(), site_, evidence));
  evidence.map = MapId("lab");
  EXPECT_STATUS(link_points_.PutEvidence(Soon(), site_, evidence), absl::StatusCode::kNotFound, HasSubstr("\"lab\""));
  evidence.map = map_;
  evidence.content = TestBlob("never sent").ref();
  EXPECT_CODE(link_points_.PutEvidence(Soon(), site_, evidence), absl::StatusCode::kInvalidArgument);

  storage::Maintenance maintenance(*pool_);
  ASSERT_OK_AND_ASSIGN(const std::int64_t collected, maintenance.CollectBlobs(Soon(), std::chrono::seconds(0), 100));
  EXPECT_EQ(collected, 1) << "the one that was replaced";
  ASSERT_OK_AND_ASSIGN(const auto listed, link_points_.ListEvidence(Soon(), site_, {LinkPointId("door")}));
  ASSERT_THAT(listed, SizeIs(2));
  EXPECT_EQ(listed[0].content, rear.ref());
  EXPECT_EQ(listed[0].time, 42);
  EXPECT_EQ(listed[1].content, cloud.ref());
  EXPECT_EQ(listed[1].encoding, 2);
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("door"), 0));
  ASSERT_OK_AND_ASSIGN(const std::int64_t freed, maintenance.CollectBlobs(Soon(), std::chrono::seconds(0), 100));
  EXPECT_EQ(freed, 2);
}

TEST_F(LinkPointStoreTest, TheAuditTrailSaysWhoDidWhat) {
  storage::CallContext ann = Soon();
  ann.actor = "ann's \"tool\"";
  ASSERT_OK_AND_ASSIGN(storage::StoredLinkPoint door,
                       link_points_.Create(ann, MakeLinkPoint(site_, "door", {MakeAnchor("hall", 0, 0)}), ""));
  door.point.tag = "new";
  storage::CallContext robot = Soon();
  robot.actor = "robot r1";
  ASSERT_OK(link_points_.Update(robot, door));
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("door"), 0));
  ASSERT_OK_AND_ASSIGN(const auto entries, audit_.List(Soon(), site_, "linkPoints/door", 0, 100));
  // Newest first: anchor and link point deleted, link point updated, anchor and link point created.
  ASSERT_THAT(entries, SizeIs(5));
  EXPECT_EQ(entries[4].actor, ann.actor);
  EXPECT_EQ(entries[4].action, storage::AuditAction::kCreated);
  EXPECT_THAT(entries[4].before, IsEmpty());
  EXPECT_EQ(entries[3].resource, "linkPoints/door/anchors/hall");
  EXPECT_EQ(entries[2].actor, "robot r1");
  EXPECT_EQ(entries[2].action, storage::AuditAction::kUpdated);
  EXPECT_THAT(entries[2].before, HasSubstr("\"tag\": \"\""));
  EXPECT_THAT(entries[2].after, HasSubstr("\"tag\": \"new\""));
  EXPECT_EQ(entries[0].actor, "");
  EXPECT_THAT(entries[0].after, IsEmpty());
  ASSERT_OK_AND_ASSIGN(const auto versions, graph_.ListVersions(Soon(), site_, 0, 3));
  ASSERT_THAT(versions, SizeIs(3));
  EXPECT_EQ(versions[0].cause, storage::GraphCause::kLinkPointRemoved);
  EXPECT_EQ(versions[1].actor, "robot r1");
  EXPECT_EQ(versions[2].cause, storage::GraphCause::kLinkPointAdded);
  EXPECT_EQ(versions[2].resource, "linkPoints/door");
  // A change that fails leaves no trace.
  EXPECT_CODE(link_points_.Update(ann, door), absl::StatusCode::kNotFound);
  ASSERT_OK_AND_ASSIGN(const auto after, audit_.List(Soon(), site_, "linkPoints/door", 0, 100));
  EXPECT_THAT(after, SizeIs(5));
}

}  // namespace
}  // namespace enfilade::testing
