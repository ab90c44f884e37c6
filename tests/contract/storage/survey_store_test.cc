// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/rearrange/survey_store.h"

#include <gmock/gmock.h>

#include <string>

#include "fmt/format.h"
#include "storage/postgres/graph/site_lease_store.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using storage::PendingSurvey;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class SurveyStoreTest : public StoreTest {
 protected:
  SessionId NewMappedSession(const std::string& id) {
    const SessionId session = NewSession(id);
    EXPECT_OK(Append(session, ScanRecords(1, 3)));
    EXPECT_OK(sessions_.Finish(Soon(), site_, session, 3));
    SetState(id, "3");
    FinishBefore(id, "2 s");
    return session;
  }
  // 1: recording, 2: being mapped, 3: mapped.
  void SetState(const std::string& id, const std::string& state) {
    database_.Sql(fmt::format("UPDATE enfilade.sessions SET state = {} WHERE session_id = '{}'", state, id));
  }

  void FinishBefore(const std::string& id, const std::string& interval) {
    database_.Sql(fmt::format(
        "UPDATE enfilade.sessions SET finish_time = now() - interval '{}' WHERE session_id = '{}'", interval, id));
  }

  const storage::postgres::SurveyStore surveys_{*pool_};
  const storage::postgres::SiteLeaseStore leases_{*pool_, storage::SiteRight::kChange};
};

TEST_F(SurveyStoreTest, SessionsAwaitASurveyOnceTheyAreMappedAndJudged) {
  NewMappedSession("s1");
  NewMappedSession("s2");
  SetState("s2", "2");
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 1, false}));
  SetState("s2", "3");
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 2, true}));
  database_.Sql("UPDATE enfilade.sessions SET door_reports = 1, laser_scans = 2 WHERE session_id = 's2'");
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 1, true}));
  database_.Sql("UPDATE enfilade.sessions SET doors_judged = true WHERE session_id = 's2'");
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 2, true}));
}

TEST_F(SurveyStoreTest, ADriveHasEndedOnceItsRobotRecordsNoMore) {
  const SessionId mapped = NewMappedSession("s1");
  NewSession("only-recorded", false);
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 1, true}));
  NewSession("recording");
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 1, false}));
  ASSERT_OK(sessions_.Finish(Soon(), site_, SessionId("recording"), 0));
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 1, false})) << "it is still mapped";
  SetState("recording", "3");
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 2, false})) << "it may begin another one";
  FinishBefore("recording", "2 s");
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 2, true}));
  // Behind a door that is not judged yet: it gets its map then.
  storage::Session behind = MakeSession(site_, SessionId("behind"), robot_, std::nullopt);
  behind.entry.previous = mapped;
  ASSERT_OK(sessions_.Create(Soon(), behind, ""));
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 2, false, true}));
  // Another robot's drive may have ended.
  ASSERT_OK(robots_.Create(Soon(), MakeRobot(site_, RobotId("r2"), "R2"), ""));
  database_.Sql("UPDATE enfilade.sessions SET robot_id = 'r2' WHERE session_id = 's1'");
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 2, true, true}));
}

TEST_F(SurveyStoreTest, MappingLagsWhileRecordsHaveWaitedForIt) {
  NewMappedSession("s1");
  const SessionId recording = NewSession("recording");
  ASSERT_OK(Append(recording, ScanRecords(1, 3)));
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 1, false, false}));
  database_.Sql(
      "UPDATE enfilade.mapping_work SET waiting_since = now() - interval '3 s' WHERE session_id = 'recording'");
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 1, false, true}));
  database_.Sql("DELETE FROM enfilade.mapping_work WHERE session_id = 'recording'");
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 1, false, false}));
}

TEST_F(SurveyStoreTest, MappingLagsWhileASessionHasWaitedForItsMap) {
  const SessionId mapped = NewMappedSession("s1");
  storage::Session behind = MakeSession(site_, SessionId("behind"), robot_, std::nullopt);
  behind.entry.previous = mapped;
  ASSERT_OK(sessions_.Create(Soon(), behind, ""));
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 1, false, true}));
  FinishBefore("s1", "1 s");
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 1, false, false}));
}

TEST_F(SurveyStoreTest, TheSiteThatHasWaitedLongestComesFirst) {
  NewMappedSession("s1");
  const SiteId other("a-newer-site");
  ASSERT_OK(sites_.Create(Soon(), MakeSite(other, "Other"), ""));
  database_.Sql(
      "SET session_replication_role = replica;"
      "INSERT INTO enfilade.sessions (site_id, session_id, robot_id, map_id, state, acknowledged_sequence,"
      " highest_sequence, laser_scans, create_time, finish_time)"
      " SELECT 'a-newer-site', 'n-' || i, 'r', 'm', 3, 1, 1, 1, now(), now() - interval '1.9 s' + i * interval '1 ms'"
      " FROM generate_series(1, 40) i");
  EXPECT_THAT(*surveys_.FindPending(Soon()),
              ElementsAre(PendingSurvey{site_, 1, true}, PendingSurvey{other, 40, true}));
}

TEST_F(SurveyStoreTest, WhatASurveyHasSeenIsNoLongerPending) {
  const SessionId first = NewMappedSession("s1");
  const SessionId second = NewMappedSession("s2");
  ASSERT_OK_AND_ASSIGN(const auto lease, leases_.Acquire(Soon(), site_, "survey", std::chrono::seconds(60)));
  ASSERT_TRUE(lease);
  ASSERT_OK(surveys_.MarkSurveyed(Soon(), *lease, {first, SessionId("none")}));
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 1, true}));
  storage::SiteLease lost = *lease;
  lost.token += 1;
  EXPECT_CODE(surveys_.MarkSurveyed(Soon(), lost, {second}), absl::StatusCode::kAborted);
  EXPECT_THAT(*surveys_.FindPending(Soon()), ElementsAre(PendingSurvey{site_, 1, true}));
  ASSERT_OK(surveys_.MarkSurveyed(Soon(), *lease, {second}));
  EXPECT_THAT(*surveys_.FindPending(Soon()), IsEmpty());
}

}  // namespace
}  // namespace enfilade::testing
