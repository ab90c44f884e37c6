// SPDX-License-Identifier: Apache-2.0
#include "storage/graph/door_verdict_store.h"

#include <chrono>
#include <cstdio>

#include "core/base/environment.h"
#include "storage/maps/feature_store.h"
#include "storage/postgres/graph/site_lease_store.h"
#include "storage/postgres/maps/numbered_map.h"
#include "tests/contract/storage/store_test.h"
#include "tests/support/pose_matchers.h"

namespace enfilade::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr auto kTtl = std::chrono::seconds(30);

class DoorVerdictStoreTest : public StoreTest {
 protected:
  static sensor::Record Report(std::int64_t sequence, sensor::DoorReport::Kind kind) {
    sensor::DoorReport report;
    report.time = 9;
    report.kind = kind;
    report.door_time = 8;
    report.T_odom_door = {1, 2, 0.5};
    return {sequence, report};
  }

  // "s1", mapped, with a candidate (2) and a passage (3), and "s2" out of it.
  void DriveThroughADoor() {
    first_ = NewSession("s1");
    ASSERT_OK(Append(first_, {ScanRecord(1), Report(2, sensor::DoorReport::Kind::kCandidate),
                              Report(3, sensor::DoorReport::Kind::kPassage)}));
    ASSERT_OK(sessions_.Finish(Soon(), site_, first_, 3));
    storage::Session next = MakeSession(site_, SessionId("s2"), robot_, std::nullopt);
    next.entry.previous = first_;
    ASSERT_OK(sessions_.Create(Soon(), next, ""));
    second_ = next.id;
  }
  void MarkMapped() { database_.Sql("UPDATE sessions SET state = 3 WHERE session_id = 's1'"); }

  storage::SiteLease Lease(const std::string& owner = "me") {
    const auto lease = leases_.Acquire(Soon(), site_, owner, kTtl);
    EXPECT_OK(lease);
    EXPECT_TRUE(lease->has_value());
    return lease->value_or(storage::SiteLease());
  }
  std::int64_t Version() { return graph_.GetVersion(Soon(), site_).value_or(-1); }

  // A passage into a new map, through a new link point.
  storage::DoorChange Through(std::int64_t sequence = 3) {
    storage::DoorChange change;
    closure::DoorVerdict& verdict = change.verdict;
    verdict.session = first_;
    verdict.sequence = sequence;
    verdict.decision = closure::DoorDecision::kLinkPointMade;
    verdict.link_point = LinkPointId("door");
    verdict.entered_map = MapId("yard");
    verdict.T_map_robot = PoseWithCovariance{{1.2, 0, 0}, 0.01 * Eigen::Matrix3d::Identity()};
    verdict.T_odom_robot = Pose2{2, 3, 0.5};
    verdict.reason = "nothing known";
    verdict.evidence = {1};
    verdict.graph_version = Version();
    closure::DoorComparison compared;
    compared.link_point = LinkPointId("other");
    compared.map = MapId("elsewhere");
    compared.image_matches = 7;
    compared.reason = "images do not agree";
    verdict.comparisons = {compared};
    change.new_map = storage::NewMap{MapId("yard"), "Map", 2, Environment::kOutdoor, "wide"};
    change.new_link_point = MakeLinkPoint(site_, "door", {MakeAnchor("hall", 4, 5), MakeAnchor("yard", 0, 0)});
    return change;
  }

  const storage::postgres::SiteLeaseStore leases_{*pool_, storage::SiteRight::kChange};
  const storage::DoorVerdictStore verdicts_{*pool_};
  SessionId first_;
  SessionId second_;
};

TEST_F(DoorVerdictStoreTest, SessionsAreJudgedWhenTheyAreFinishedAndMapped) {
  DriveThroughADoor();
  EXPECT_THAT(*verdicts_.FindPending(Soon(), 10), IsEmpty());
  MarkMapped();
  EXPECT_THAT(*verdicts_.FindPending(Soon(), 10), ElementsAre(storage::PendingDoors{site_, first_}));
  ASSERT_OK_AND_ASSIGN(const auto reports, verdicts_.ReadReports(Soon(), site_, first_));
  ASSERT_THAT(reports, SizeIs(2));
  EXPECT_EQ(reports[0].sequence, 2);
  EXPECT_EQ(reports[1].report.kind, sensor::DoorReport::Kind::kPassage);
  EXPECT_FALSE(reports[1].judged);
  EXPECT_THAT(*verdicts_.ListWaiting(Soon(), site_, first_), ElementsAre(second_));
}

// Many of one site are pending for longer than the only one of another.
TEST_F(DoorVerdictStoreTest, SitesTakeTurnsHoweverManyOfOneArePending) {
  DriveThroughADoor();
  MarkMapped();
  const SiteId other("other");
  ASSERT_OK(sites_.Create(Soon(), MakeSite(other, "Other"), ""));
  database_.Sql(
      "SET session_replication_role = replica;"
      "INSERT INTO enfilade.sessions (site_id, session_id, robot_id, state, error, acknowledged_sequence,"
      " highest_sequence, door_reports, create_time, finish_time)"
      " SELECT 'other', 'old-' || to_char(i, 'FM00'), 'r', 4, 'failed', 1, 1, 1, now() - interval '1 day',"
      " now() - interval '1 day' + i * interval '1 s' FROM generate_series(1, 40) i");
  ASSERT_OK_AND_ASSIGN(const auto two, verdicts_.FindPending(Soon(), 2));
  EXPECT_THAT(two, ElementsAre(storage::PendingDoors{site_, first_}, storage::PendingDoors{other, SessionId("old-01")}))
      << "the first of each site";
  storage::PostponedDoors postponed;
  postponed.sessions = {{other, SessionId("old-01")}, {site_, SessionId("old-02")}, {other, SessionId("old-03")}};
  ASSERT_OK_AND_ASSIGN(const auto four, verdicts_.FindPending(Soon(), 4, postponed));
  EXPECT_THAT(four, ElementsAre(storage::PendingDoors{site_, first_}, storage::PendingDoors{other, SessionId("old-02")},
                                storage::PendingDoors{other, SessionId("old-04")},
                                storage::PendingDoors{other, SessionId("old-05")}));
  postponed.sites = {other};
  ASSERT_OK_AND_ASSIGN(const auto one, verdicts_.FindPending(Soon(), 50, postponed));
  EXPECT_THAT(one, ElementsAre(storage::PendingDoors{site_, first_}));
}

// The maps have the numbers 1 to 20,000 but for some that were removed.
TEST_F(DoorVerdictStoreTest, ANewMapsNameIsFoundInFewSteps) {
  database_.Sql(
      "SET session_replication_role = replica;"
      "INSERT INTO enfilade.maps (site_id, map_id, display_name, environment)"
      " SELECT 'campus', 'map-' || i, 'Map ' || i, 1 FROM generate_series(1, 20000) i WHERE i NOT IN (7, 15000);"
      "ANALYZE enfilade.maps");
  const std::vector<std::string> plan = database_.Sql(
      "SET plan_cache_mode = force_generic_plan; PREPARE s (text, text, text, int, smallint, text) AS " +
      std::string(storage::postgres::kInsertNumberedMap.sql) +
      "; EXPLAIN (ANALYZE, FORMAT TEXT, TIMING OFF) EXECUTE s ('campus', 'new', 'Map', 0, 1::smallint, '')");
  double rows = 0;  // that all steps of the plan gave, every time
  for (const std::string& line : plan) {
    double given = 0;
    double loops = 0;
    const auto actual = line.find("(actual rows=");
    if (actual == std::string::npos) continue;
    ASSERT_EQ(std::sscanf(line.c_str() + actual, "(actual rows=%lf loops=%lf)", &given, &loops), 2) << line;
    rows += given * loops;
  }
  EXPECT_GT(rows, 30) << "the plan was read";
  EXPECT_LT(rows, 500) << ::testing::PrintToString(plan);
  EXPECT_THAT(plan, Not(Contains(HasSubstr("Seq Scan on maps"))));
  EXPECT_EQ(database_.SqlValue("SELECT display_name FROM enfilade.maps WHERE map_id = 'new'"), "Map 20001");
}

TEST_F(DoorVerdictStoreTest, AVerdictIsStoredWithAllThatFollowsFromIt) {
  DriveThroughADoor();
  MarkMapped();
  const storage::SiteLease lease = Lease();
  const storage::DoorChange change = Through();
  ASSERT_OK(verdicts_.Commit(Soon(), lease, change));

  ASSERT_OK_AND_ASSIGN(const storage::Map yard, maps_.Get(Soon(), site_, MapId("yard")));
  EXPECT_EQ(yard.display_name, "Map 1");
  EXPECT_EQ(yard.level, 2);
  EXPECT_EQ(yard.environment, Environment::kOutdoor);
  EXPECT_EQ(yard.slam_profile, "wide");
  ASSERT_OK_AND_ASSIGN(const storage::StoredLinkPoint door, link_points_.Get(Soon(), site_, LinkPointId("door")));
  EXPECT_THAT(door.point.anchors, SizeIs(2));
  EXPECT_TRUE(door.T_world_place.has_value());
  ASSERT_OK_AND_ASSIGN(const storage::Session next, sessions_.Get(Soon(), site_, second_));
  EXPECT_EQ(next.map, MapId("yard"));
  ASSERT_TRUE(next.entry.T_map_robot.has_value());
  EXPECT_THAT(next.entry.T_map_robot->pose, PoseNear(Pose2{1.2, 0, 0}, 1e-12, 1e-12));
  EXPECT_EQ(next.entry.T_odom_robot, change.verdict.T_odom_robot);

  ASSERT_OK_AND_ASSIGN(const auto listed, verdicts_.List(Soon(), site_, first_, 0, 10));
  ASSERT_THAT(listed, SizeIs(1));
  EXPECT_EQ(listed[0].decision, closure::DoorDecision::kLinkPointMade);
  EXPECT_EQ(listed[0].link_point, LinkPointId("door"));
  EXPECT_EQ(listed[0].evidence, change.verdict.evidence);
  EXPECT_EQ(listed[0].graph_version, change.verdict.graph_version);
  EXPECT_GT(listed[0].create_time, 0);
  ASSERT_THAT(listed[0].comparisons, SizeIs(1));
  EXPECT_EQ(listed[0].comparisons[0].image_matches, 7);
  EXPECT_FALSE(listed[0].comparisons[0].chi2.has_value());
  EXPECT_CODE(verdicts_.List(Soon(), site_, SessionId("none"), 0, 10), absl::StatusCode::kNotFound);
  ASSERT_OK_AND_ASSIGN(const auto passage, verdicts_.FindPassage(Soon(), site_, first_));
  EXPECT_EQ(passage->entered_map, MapId("yard"));
}

TEST_F(DoorVerdictStoreTest, ReportsWhichPassagesLedIntoAMap) {
  DriveThroughADoor();
  MarkMapped();
  ASSERT_OK_AND_ASSIGN(const auto none, verdicts_.ListInto(Soon(), site_, MapId("yard"), 10));
  EXPECT_THAT(none, IsEmpty());
  const storage::DoorChange change = Through();
  ASSERT_OK(verdicts_.Commit(Soon(), Lease(), change));
  ASSERT_OK_AND_ASSIGN(const auto into, verdicts_.ListInto(Soon(), site_, MapId("yard"), 10));
  ASSERT_THAT(into, SizeIs(1));
  EXPECT_EQ(into[0].session, first_);
  EXPECT_EQ(into[0].sequence, change.verdict.sequence);
  EXPECT_EQ(into[0].link_point, change.verdict.link_point);
  EXPECT_EQ(into[0].entered_map, change.verdict.entered_map);
  ASSERT_OK_AND_ASSIGN(const auto limited, verdicts_.ListInto(Soon(), site_, MapId("yard"), 0));
  EXPECT_THAT(limited, IsEmpty());
  ASSERT_OK_AND_ASSIGN(const auto elsewhere, verdicts_.ListInto(Soon(), site_, MapId("hall"), 10));
  EXPECT_THAT(elsewhere, IsEmpty());
}

TEST_F(DoorVerdictStoreTest, CandidatesAreListedWithWhatTheyWereMadeFor) {
  DriveThroughADoor();
  MarkMapped();
  const storage::SiteLease lease = Lease();
  EXPECT_THAT(*verdicts_.ListCandidateReports(Soon(), site_), IsEmpty());
  storage::DoorChange change;
  change.verdict.session = first_;
  change.verdict.sequence = 2;
  change.verdict.decision = closure::DoorDecision::kCandidateMade;
  change.verdict.link_point = LinkPointId("seen");
  change.verdict.graph_version = Version();
  change.new_link_point = MakeLinkPoint(site_, "seen", {MakeAnchor("hall", 4, 5)});
  ASSERT_OK(verdicts_.Commit(Soon(), lease, change));
  ASSERT_OK(verdicts_.Commit(Soon(), lease, Through()));
  ASSERT_OK_AND_ASSIGN(const auto candidates, verdicts_.ListCandidateReports(Soon(), site_));
  ASSERT_THAT(candidates, SizeIs(1)) << "not the passage's";
  EXPECT_EQ(candidates[0].candidate, LinkPointId("seen"));
  EXPECT_EQ(sensor::RecordPayload(candidates[0].report), Report(2, sensor::DoorReport::Kind::kCandidate).payload);
  ASSERT_OK(link_points_.Delete(Soon(), site_, LinkPointId("seen"), 0));
  EXPECT_THAT(*verdicts_.ListCandidateReports(Soon(), site_), IsEmpty());
}

TEST_F(DoorVerdictStoreTest, JudgedTwiceItChangesNothing) {
  DriveThroughADoor();
  MarkMapped();
  const storage::SiteLease lease = Lease();
  const storage::DoorChange change = Through();
  ASSERT_OK(verdicts_.Commit(Soon(), lease, change));
  const std::int64_t version = Version();
  ASSERT_OK(verdicts_.Commit(Soon(), lease, change));
  EXPECT_EQ(Version(), version);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM link_points"), "1");
}

TEST_F(DoorVerdictStoreTest, ALaterGraphOrALostLeaseStoresNothing) {
  DriveThroughADoor();
  MarkMapped();
  const storage::SiteLease lease = Lease();
  const storage::DoorChange change = Through();
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "seen", {MakeAnchor("hall", 1, 1)}), ""));
  EXPECT_STATUS(verdicts_.Commit(Soon(), lease, change), absl::StatusCode::kAborted, HasSubstr("decide again"));
  ASSERT_OK(leases_.Release(Soon(), lease));
  Lease("another");
  EXPECT_STATUS(verdicts_.Commit(Soon(), lease, Through()), absl::StatusCode::kAborted,
                HasSubstr("has lost the lease"));
  EXPECT_CODE(verdicts_.MarkJudged(Soon(), lease, first_), absl::StatusCode::kAborted);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM maps WHERE map_id = 'yard'"), "0");
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM door_verdicts"), "0");
  EXPECT_EQ(sessions_.Get(Soon(), site_, second_)->map, std::nullopt);
}

TEST_F(DoorVerdictStoreTest, ARedundantLinkPointIsRefusedAndNothingIsHalfDone) {
  DriveThroughADoor();
  MarkMapped();
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("yard"), "Yard"), ""));
  ASSERT_OK(link_points_.Create(
      Soon(), MakeLinkPoint(site_, "there", {MakeAnchor("hall", 4, 5), MakeAnchor("yard", 0, 0)}), ""));
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "candidate", {MakeAnchor("yard", 0.1, 0)}), ""));
  storage::DoorChange change = Through();
  change.new_map.reset();
  change.new_link_point.reset();
  ASSERT_OK_AND_ASSIGN(change.link_point, link_points_.Get(Soon(), site_, LinkPointId("candidate")));
  change.link_point->point.anchors.push_back(MakeAnchor("hall", 4.1, 5));
  EXPECT_CODE(verdicts_.Commit(Soon(), Lease(), change), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM door_verdicts"), "0");
  EXPECT_EQ(link_points_.Get(Soon(), site_, LinkPointId("candidate"))->point.anchors.size(), 1U);
}

TEST_F(DoorVerdictStoreTest, APromotedCandidateMovesAndTakesItsOwnSideAlong) {
  DriveThroughADoor();
  MarkMapped();
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("yard"), "Yard"), ""));
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "candidate", {MakeAnchor("yard", 2, 0)}), ""));
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "own", {MakeAnchor("hall", 4, 3)}), ""));
  const TestBlob image("image");
  ASSERT_OK(blobs_.Put(Soon(), site_, {image.view()}));
  storage::DoorChange change = Through();
  change.new_map.reset();
  change.new_link_point.reset();
  change.consumed = {LinkPointId("own")};
  ASSERT_OK_AND_ASSIGN(change.link_point, link_points_.Get(Soon(), site_, LinkPointId("candidate")));
  change.link_point->point.anchors = {MakeAnchor("yard", 0, 0), MakeAnchor("hall", 4, 5)};
  change.link_point->point.direction = MapId("yard");
  const storage::Evidence seen{LinkPointId("candidate"), map_, storage::EvidenceKind::kRearImage, 1, image.ref(), 5,
                               Pose2{4, 4, 1.5}};
  change.evidence = {seen, seen};
  change.evidence[1].T_map_robot = Pose2{4, 3.5, 1.5};
  ASSERT_OK(verdicts_.Commit(Soon(), Lease(), change));
  EXPECT_CODE(link_points_.Get(Soon(), site_, LinkPointId("own")), absl::StatusCode::kNotFound);
  ASSERT_OK_AND_ASSIGN(const auto evidence, link_points_.ListEvidence(Soon(), site_, {LinkPointId("candidate")}));
  ASSERT_THAT(evidence, SizeIs(2));
  EXPECT_EQ(evidence[0].T_map_robot, (Pose2{4, 4, 1.5}));
  EXPECT_EQ(evidence[1].T_map_robot, (Pose2{4, 3.5, 1.5}));
  // One that people attach takes the place of the series.
  storage::Evidence attached = seen;
  attached.T_map_robot.reset();
  ASSERT_OK(link_points_.PutEvidence(Soon(), site_, attached));
  ASSERT_OK_AND_ASSIGN(const auto after, link_points_.ListEvidence(Soon(), site_, {LinkPointId("candidate")}));
  ASSERT_THAT(after, SizeIs(1));
  EXPECT_EQ(after[0].T_map_robot, std::nullopt);
}

TEST_F(DoorVerdictStoreTest, ASessionMadeAfterTheVerdictGetsItsMapLater) {
  DriveThroughADoor();
  MarkMapped();
  const storage::SiteLease lease = Lease();
  ASSERT_OK(verdicts_.Commit(Soon(), lease, Through()));
  EXPECT_FALSE(sessions_.Get(Soon(), site_, first_)->doors_judged);
  ASSERT_OK(verdicts_.MarkJudged(Soon(), lease, first_));
  EXPECT_TRUE(sessions_.Get(Soon(), site_, first_)->doors_judged);
  EXPECT_THAT(*verdicts_.FindPending(Soon(), 10), IsEmpty());
  storage::Session late = MakeSession(site_, SessionId("s3"), robot_, std::nullopt);
  late.entry.previous = first_;
  ASSERT_OK(sessions_.Create(Soon(), late, ""));
  EXPECT_THAT(*verdicts_.FindPending(Soon(), 10), ElementsAre(storage::PendingDoors{site_, first_}));
  ASSERT_OK_AND_ASSIGN(const auto passage, verdicts_.FindPassage(Soon(), site_, first_));
  ASSERT_OK(verdicts_.Enter(Soon(), lease,
                            {.previous = first_,
                             .new_map = {},
                             .map = *passage->entered_map,
                             .T_map_robot = passage->T_map_robot,
                             .T_odom_robot = passage->T_odom_robot}));
  EXPECT_EQ(sessions_.Get(Soon(), site_, late.id)->map, MapId("yard"));
  EXPECT_THAT(*verdicts_.FindPending(Soon(), 10), IsEmpty());
}

TEST_F(DoorVerdictStoreTest, ASessionAfterADeletedOneIsNotForgotten) {
  DriveThroughADoor();
  ASSERT_OK(sessions_.Delete(Soon(), site_, first_));
  EXPECT_THAT(*verdicts_.FindPending(Soon(), 10), ElementsAre(storage::PendingDoors{site_, first_}));
  ASSERT_OK(verdicts_.Enter(Soon(), Lease(),
                            {.previous = first_,
                             .new_map = storage::NewMap{MapId("new"), "Map", 0, Environment::kIndoor, ""},
                             .map = MapId("new"),
                             .T_map_robot = {},
                             .T_odom_robot = {}}));
  ASSERT_OK_AND_ASSIGN(const storage::Session next, sessions_.Get(Soon(), site_, second_));
  EXPECT_EQ(next.map, MapId("new"));
  EXPECT_FALSE(next.entry.T_map_robot.has_value());
  const storage::EnteredMap again{
      .previous = first_, .new_map = {}, .map = MapId("new"), .T_map_robot = {}, .T_odom_robot = {}};
  EXPECT_CODE(verdicts_.Enter(Soon(), storage::SiteLease{site_, "me", 99}, again), absl::StatusCode::kAborted);
}

TEST_F(DoorVerdictStoreTest, NewMapsTakeANumberThatIsFree) {
  DriveThroughADoor();
  MarkMapped();
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("a"), "Map 1"), ""));
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("b"), "Map 3"), ""));
  ASSERT_OK(verdicts_.Commit(Soon(), Lease(), Through()));
  EXPECT_EQ(maps_.Get(Soon(), site_, MapId("yard"))->display_name, "Map 2");
}

TEST_F(DoorVerdictStoreTest, SitesAndSessionsTakeTheirVerdictsAlong) {
  DriveThroughADoor();
  MarkMapped();
  ASSERT_OK(verdicts_.Commit(Soon(), Lease(), Through()));
  DeleteSite(site_);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM door_verdicts"), "0");
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM site_leases"), "0");
}

TEST_F(DoorVerdictStoreTest, ASitesLeaseHasOneHolderAndTokensOnlyGrow) {
  const storage::SiteLease lease = Lease();
  EXPECT_FALSE(leases_.Acquire(Soon(), site_, "other", kTtl)->has_value());
  ASSERT_OK(leases_.Renew(Soon(), lease, kTtl));
  ASSERT_OK(leases_.Release(Soon(), lease));
  const storage::SiteLease next = Lease("other");
  EXPECT_GT(next.token, lease.token);
  EXPECT_CODE(leases_.Renew(Soon(), lease, kTtl), absl::StatusCode::kAborted);
  ASSERT_OK(leases_.Release(Soon(), lease));  // lost: nothing happens
  EXPECT_FALSE(leases_.Acquire(Soon(), site_, "third", kTtl)->has_value());
  EXPECT_CODE(leases_.Acquire(Soon(), SiteId("none"), "me", kTtl), absl::StatusCode::kNotFound);
  // One that dies is followed when its time is over.
  database_.Sql("UPDATE site_leases SET expires_at = now() - interval '1 second'");
  EXPECT_TRUE(leases_.Acquire(Soon(), site_, "third", kTtl)->has_value());
}

TEST_F(DoorVerdictStoreTest, FeaturesAreKeptBesideTheirImageAndGoWithIt) {
  const storage::FeatureStore features{*pool_};
  const TestBlob image("an image");
  ASSERT_OK(features.Put(Soon(), site_, image.sha256(), "early"));
  EXPECT_EQ(*features.Find(Soon(), site_, image.sha256()), "") << "there is no such image";
  ASSERT_OK(blobs_.Put(Soon(), site_, {image.view()}));
  ASSERT_OK(features.Put(Soon(), site_, image.sha256(), "found"));
  ASSERT_OK(features.Put(Soon(), site_, image.sha256(), "found again"));
  EXPECT_EQ(*features.Find(Soon(), site_, image.sha256()), "found again");
  database_.Sql("DELETE FROM blobs");
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM image_features"), "0");
}

}  // namespace
}  // namespace enfilade::testing
