// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/link_point_store.h"

#include <cmath>
#include <limits>

#include "core/base/environment.h"
#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Maps "hall" (the root), "lab" and "yard", each on a level of its own where `levels` says so.
class LinkPointStoreTest : public StoreContractTest {
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

TEST_F(LinkPointStoreTest, WhatIsRedundantDependsOnUseForceAndTheChange) {
  // "door" as `first` says, then the change of the case on a second link point at the same place.
  struct Case {
    std::string name;
    bool first_forced = false;
    bool first_suspended = false;
    bool second_forced = false;
    absl::StatusCode created = absl::StatusCode::kOk;
  };
  const std::vector<Case> cases = {
      {"plain", false, false, false, absl::StatusCode::kAlreadyExists},
      {"forced", false, false, true, absl::StatusCode::kOk},
      {"beside a forced one", true, false, false, absl::StatusCode::kAlreadyExists},
      {"beside a suspended one", false, true, false, absl::StatusCode::kOk},
      {"beside a suspended and forced one", true, true, false, absl::StatusCode::kOk},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Case& test = cases[i];
    const double x = 20.0 * static_cast<double>(i);
    const std::string id = "c" + std::to_string(i);
    ASSERT_OK(Create(id + "-first", {MakeAnchor("hall", x, 0), MakeAnchor("lab", x, 5)}, test.first_forced));
    if (test.first_suspended) {
      ASSERT_OK(link_points_.SetSuspended(Soon(), site_, LinkPointId(id + "-first"), 0, true));
    }
    const auto second =
        Create(id + "-second", {MakeAnchor("hall", x + 0.1, 0), MakeAnchor("lab", x, 5)}, test.second_forced);
    EXPECT_CODE(second, test.created) << test.name;
    EXPECT_EQ(Get(id + "-second").ok(), test.created == absl::StatusCode::kOk) << test.name;
  }
}

TEST_F(LinkPointStoreTest, OneThatIsNoLongerForcedMustFit) {
  ASSERT_OK(Create("door", {MakeAnchor("hall", 10, 0), MakeAnchor("lab", 0, 0)}));
  ASSERT_OK_AND_ASSIGN(storage::StoredLinkPoint forced,
                       Create("forced", {MakeAnchor("hall", 10, 0.1), MakeAnchor("lab", 0, 0)}, true));
  forced.forced = false;
  EXPECT_STATUS(link_points_.Update(Soon(), forced), absl::StatusCode::kAlreadyExists, HasSubstr("linkPoints/door"));
  ASSERT_OK_AND_ASSIGN(const storage::StoredLinkPoint unchanged, Get("forced"));
  EXPECT_TRUE(unchanged.forced);
  EXPECT_EQ(unchanged.etag, forced.etag);
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("door"), 0));
  ASSERT_OK_AND_ASSIGN(const storage::StoredLinkPoint updated, link_points_.Update(Soon(), forced));
  EXPECT_FALSE(updated.forced);
}

TEST_F(LinkPointStoreTest, MovingAnAnchorOntoAnotherLinkPointIsRefused) {
  ASSERT_OK(Create("door", {MakeAnchor("hall", 10, 0), MakeAnchor("lab", 0, 0)}));
  ASSERT_OK_AND_ASSIGN(storage::StoredLinkPoint other,
                       Create("other", {MakeAnchor("hall", 15, 0), MakeAnchor("lab", 5, 0)}));
  other.point.anchors[0].T_map_place.x = 10.1;
  ASSERT_OK_AND_ASSIGN(other, link_points_.Update(Soon(), other));
  other.point.anchors[1].T_map_place.x = 0.1;
  const std::int64_t version = Version();
  EXPECT_STATUS(link_points_.Update(Soon(), other), absl::StatusCode::kAlreadyExists,
                AllOf(HasSubstr("linkPoints/other"), HasSubstr("the same 2 maps"), HasSubstr("linkPoints/door")));
  EXPECT_EQ(Version(), version) << "a change that fails makes no version";
}

TEST_F(LinkPointStoreTest, TheNearestOfSeveralIsNamed) {
  ASSERT_OK(Create("a", {MakeAnchor("hall", 0.28, 0), MakeAnchor("lab", 0, 0)}));
  ASSERT_OK(Create("b", {MakeAnchor("hall", 0.05, 0), MakeAnchor("lab", 0, 0)}, true));
  ASSERT_OK(Create("c", {MakeAnchor("hall", 0.15, 0), MakeAnchor("lab", 0, 0)}, true));
  EXPECT_STATUS(Create("d", {MakeAnchor("hall", 0, 0), MakeAnchor("lab", 0, 0)}), absl::StatusCode::kAlreadyExists,
                AllOf(HasSubstr("linkPoints/b"), HasSubstr("0.05 m")));
}

TEST_F(LinkPointStoreTest, AnUpdateKeepsTheOrderOfAnchorsAndAppendsNewOnes) {
  ASSERT_OK_AND_ASSIGN(storage::StoredLinkPoint lift,
                       Create("lift", {MakeAnchor("yard", 1, 0), MakeAnchor("hall", 2, 0)}));
  lift.point.anchors = {MakeAnchor("lab", 3, 0), MakeAnchor("hall", 4, 0), MakeAnchor("yard", 5, 0)};
  ASSERT_OK(link_points_.Update(Soon(), lift));
  ASSERT_OK_AND_ASSIGN(lift, Get("lift"));
  std::vector<std::string> maps;
  for (const graph::Anchor& anchor : lift.point.anchors) maps.push_back(anchor.map.value());
  EXPECT_THAT(maps, ElementsAre("yard", "hall", "lab"));
  EXPECT_EQ(lift.point.anchors[0].T_map_place.x, 5.0);
  EXPECT_EQ(lift.point.anchors[1].T_map_place.x, 4.0);
}

TEST_F(LinkPointStoreTest, ADirectionNeedsAnAnchor) {
  storage::StoredLinkPoint door = MakeLinkPoint(site_, "door", {MakeAnchor("hall", 0, 0), MakeAnchor("lab", 0, 0)});
  door.point.direction = MapId("yard");
  EXPECT_STATUS(link_points_.Create(Soon(), door, ""), absl::StatusCode::kInvalidArgument, HasSubstr("\"yard\""));
  door.point.direction = MapId("lab");
  ASSERT_OK_AND_ASSIGN(storage::StoredLinkPoint created, link_points_.Create(Soon(), door, ""));
  created.point.anchors.pop_back();
  EXPECT_STATUS(link_points_.Update(Soon(), created), absl::StatusCode::kInvalidArgument, HasSubstr("\"lab\""));
}

TEST_F(LinkPointStoreTest, SuspendingWhatIsSuspendedIsAVersionAllTheSame) {
  ASSERT_OK_AND_ASSIGN(const auto door, Create("door", {MakeAnchor("hall", 0, 0), MakeAnchor("lab", 0, 0)}));
  ASSERT_OK_AND_ASSIGN(const auto once, link_points_.SetSuspended(Soon(), site_, LinkPointId("door"), door.etag, true));
  ASSERT_OK_AND_ASSIGN(const auto twice, link_points_.SetSuspended(Soon(), site_, LinkPointId("door"), 0, true));
  EXPECT_EQ(twice.point.graph_version, once.point.graph_version + 1);
  EXPECT_NE(twice.etag, once.etag);
  ASSERT_OK_AND_ASSIGN(const auto resumed, link_points_.SetSuspended(Soon(), site_, LinkPointId("door"), 0, false));
  EXPECT_EQ(resumed.point.use, graph::LinkPointUse::kUsed);
  EXPECT_CODE(link_points_.SetSuspended(Soon(), site_, LinkPointId("gate"), 0, true), absl::StatusCode::kNotFound);
}

TEST_F(LinkPointStoreTest, EvidenceIsReplacedByKindAndGoesWithItsAnchor) {
  ASSERT_OK_AND_ASSIGN(storage::StoredLinkPoint door,
                       Create("door", {MakeAnchor("hall", 0, 0), MakeAnchor("lab", 0, 0)}));
  ASSERT_OK(Create("other", {MakeAnchor("hall", 9, 0)}));
  const TestBlob front("front"), rear("rear"), cloud("cloud"), newer("newer cloud");
  ASSERT_OK(blobs_.Put(Soon(), site_, {front.view(), rear.view(), cloud.view(), newer.view()}));
  const auto put = [&](const std::string& id, const std::string& map, storage::EvidenceKind kind,
                       const TestBlob& blob) {
    return link_points_.PutEvidence(Soon(), site_, {LinkPointId(id), MapId(map), kind, 1, blob.ref(), 42});
  };
  ASSERT_OK(put("door", "lab", storage::EvidenceKind::kCloud, cloud));
  ASSERT_OK(put("door", "hall", storage::EvidenceKind::kRearImage, rear));
  ASSERT_OK(put("door", "hall", storage::EvidenceKind::kFrontImage, front));
  ASSERT_OK(put("other", "hall", storage::EvidenceKind::kCloud, cloud));
  ASSERT_OK(put("door", "lab", storage::EvidenceKind::kCloud, newer));
  const auto list = [&](const std::vector<LinkPointId>& ids) {
    const auto evidence = link_points_.ListEvidence(Soon(), site_, ids);
    EXPECT_OK(evidence);
    std::vector<std::string> names;
    for (const storage::Evidence& item : *evidence) {
      names.push_back(item.link_point.value() + "/" + item.map.value() + "/" +
                      std::to_string(static_cast<int>(item.kind)));
      EXPECT_EQ(item.time, 42);
      EXPECT_FALSE(item.T_map_robot);
    }
    return names;
  };
  EXPECT_THAT(list({LinkPointId("other"), LinkPointId("door"), LinkPointId("gate")}),
              ElementsAre("door/hall/1", "door/hall/2", "door/lab/3", "other/hall/3"));
  EXPECT_THAT(list({}), IsEmpty());
  ASSERT_OK_AND_ASSIGN(const auto kept, link_points_.ListEvidence(Soon(), site_, {LinkPointId("door")}));
  EXPECT_EQ(kept.back().content, newer.ref());
  EXPECT_CODE(put("door", "yard", storage::EvidenceKind::kCloud, cloud), absl::StatusCode::kNotFound);
  EXPECT_CODE(put("gate", "hall", storage::EvidenceKind::kCloud, cloud), absl::StatusCode::kNotFound);
  EXPECT_CODE(put("door", "hall", storage::EvidenceKind::kCloud, TestBlob("never sent")),
              absl::StatusCode::kInvalidArgument);
  door.point.anchors = {MakeAnchor("hall", 0, 0), MakeAnchor("yard", 0, 0)};
  ASSERT_OK(link_points_.Update(Soon(), door));
  EXPECT_THAT(list({LinkPointId("door")}), ElementsAre("door/hall/1", "door/hall/2"));
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("door"), 0));
  EXPECT_THAT(list({LinkPointId("door"), LinkPointId("other")}), ElementsAre("other/hall/3"));
}

TEST_F(LinkPointStoreTest, PagesOfEverySizeListEachOnce) {
  std::vector<std::string> expected;
  for (const char* id : {"a", "b", "b2", "c", "d"}) {
    ASSERT_OK(Create(id, {MakeAnchor("hall", static_cast<double>(expected.size()), 0)}));
    expected.push_back(id);
  }
  for (const auto& map : {std::optional<MapId>(), std::optional<MapId>("hall")}) {
    for (int limit = 1; limit <= 6; ++limit) {
      std::vector<std::string> listed;
      storage::PageRequest page{limit, ""};
      while (true) {
        ASSERT_OK_AND_ASSIGN(const auto link_points, link_points_.List(Soon(), site_, {.map = map}, page));
        if (link_points.empty()) break;
        for (const auto& link_point : link_points) listed.push_back(link_point.point.id.value());
        page.after = listed.back();
      }
      EXPECT_EQ(listed, expected) << limit;
    }
  }
}

TEST_F(LinkPointStoreTest, ARequestIdThatWasUsedForSomethingElseIsRefused) {
  const storage::RequestId request("request", std::string(32, 'a'));
  const storage::RequestId other("request", std::string(32, 'b'));
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "r1", {MakeAnchor("hall", 40, 0)}), request));
  EXPECT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "r2", {MakeAnchor("hall", 40, 0)}), request));
  EXPECT_CODE(link_points_.Create(Soon(), MakeLinkPoint(site_, "r3", {MakeAnchor("hall", 60, 0)}), other).status(),
              absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace enfilade::testing
