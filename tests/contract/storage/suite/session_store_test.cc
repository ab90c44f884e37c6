// SPDX-License-Identifier: Apache-2.0
#include "storage/sessions/session_store.h"

#include "fmt/format.h"
#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class SessionStoreTest : public StoreContractTest {
 protected:
  storage::Session Get(const SessionId& id) {
    const auto session = sessions_.Get(Soon(), site_, id);
    EXPECT_OK(session);
    return *session;
  }
  std::vector<std::string> List(const storage::SessionFilter& filter, int limit = 100,
                                const std::optional<storage::SessionPosition>& after = std::nullopt) {
    const auto sessions = sessions_.List(Soon(), site_, filter, limit, after);
    EXPECT_OK(sessions);
    std::vector<std::string> ids;
    for (const storage::Session& session : *sessions) ids.push_back(session.id.value());
    return ids;
  }
};

TEST_F(SessionStoreTest, ANewSessionIsRecordingAndEmpty) {
  const storage::Session session = Get(NewSession("s1"));
  EXPECT_EQ(session.robot, robot_);
  EXPECT_EQ(session.map, map_);
  EXPECT_EQ(session.state, storage::SessionState::kRecording);
  EXPECT_EQ(session.acknowledged_sequence, 0);
  EXPECT_EQ(session.mapped_sequence, 0);
  EXPECT_EQ(session.record_counts, storage::RecordCounts());
  EXPECT_EQ(session.first_time, std::nullopt);
  EXPECT_EQ(session.finish_time, std::nullopt);
  EXPECT_EQ(Get(NewSession("s2", false)).map, std::nullopt);
}

TEST_F(SessionStoreTest, SaysWhatIsMissing) {
  EXPECT_STATUS(sessions_.Create(Soon(), MakeSession(SiteId("nowhere"), SessionId("s"), robot_, map_), ""),
                absl::StatusCode::kNotFound, HasSubstr("sites/nowhere does not"));
  EXPECT_STATUS(sessions_.Create(Soon(), MakeSession(site_, SessionId("s"), RobotId("r9"), map_), ""),
                absl::StatusCode::kNotFound, HasSubstr("robots/r9 does not"));
  EXPECT_STATUS(sessions_.Create(Soon(), MakeSession(site_, SessionId("s"), robot_, MapId("m9")), ""),
                absl::StatusCode::kNotFound, HasSubstr("maps/m9 does not"));
}

TEST_F(SessionStoreTest, KeepsHowTheRobotCameIntoTheMap) {
  const SessionId first = NewSession("s1");
  storage::Session after_a_door = MakeSession(site_, SessionId("s2"), robot_, std::nullopt);
  after_a_door.entry.previous = first;
  ASSERT_OK_AND_ASSIGN(const storage::Session waiting, sessions_.Create(Soon(), after_a_door, ""));
  EXPECT_EQ(waiting.entry.previous, first);
  EXPECT_EQ(waiting.map, std::nullopt);
  // Nothing is mapped yet, as its map is not known.
  ASSERT_OK_AND_ASSIGN(const storage::Session finished, sessions_.Finish(Soon(), site_, waiting.id, 0));
  EXPECT_EQ(finished.state, storage::SessionState::kFinished);

  storage::Session placed = MakeSession(site_, SessionId("s3"), robot_, map_);
  placed.entry.T_map_robot = PoseWithCovariance{{1.0, 2.0, 0.5}, Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal()};
  placed.entry.T_odom_robot = Pose2{-1.0, 0.0, 3.0};
  ASSERT_OK(sessions_.Create(Soon(), placed, ""));
  const storage::Session stored = Get(placed.id);
  ASSERT_TRUE(stored.entry.T_map_robot.has_value());
  EXPECT_EQ(stored.entry.T_map_robot->pose, placed.entry.T_map_robot->pose);
  EXPECT_EQ(stored.entry.T_map_robot->covariance, placed.entry.T_map_robot->covariance);
  EXPECT_EQ(stored.entry.T_odom_robot, placed.entry.T_odom_robot);

  placed.id = SessionId("s4");
  placed.entry.previous = SessionId("nowhere");
  EXPECT_STATUS(sessions_.Create(Soon(), placed, ""), absl::StatusCode::kNotFound,
                HasSubstr("sessions/nowhere does not"));
}

TEST_F(SessionStoreTest, ManyRepeatedCreationsMakeOneSession) {
  for (int i = 0; i < 50; ++i) {
    ASSERT_OK_AND_ASSIGN(const storage::Session session,
                         sessions_.Create(Soon(), MakeSession(site_, SessionId("s"), robot_, map_), "request"));
    EXPECT_EQ(session.id, SessionId("s"));
  }
  EXPECT_THAT(List({}), ElementsAre("s"));
  EXPECT_CODE(sessions_.Create(Soon(), MakeSession(site_, SessionId("s"), robot_, map_), "another"),
              absl::StatusCode::kAlreadyExists);
}

TEST_F(SessionStoreTest, ListsTheNewestFirstInPages) {
  for (const char* id : {"c", "a", "b"}) NewSession(id);
  NewSession("recorded", false);
  EXPECT_THAT(List({}), ElementsAre("recorded", "b", "a", "c"));
  EXPECT_THAT(List({}, 2), ElementsAre("recorded", "b"));
  const storage::SessionPosition last{Get(SessionId("b")).create_time, SessionId("b")};
  EXPECT_THAT(List({}, 2, last), ElementsAre("a", "c"));
  storage::SessionFilter filter;
  filter.map = map_;
  EXPECT_THAT(List(filter), ElementsAre("b", "a", "c"));
  filter.robot = RobotId("r9");
  EXPECT_THAT(List(filter), ElementsAre());
  filter = {};
  filter.state = storage::SessionState::kFinished;
  EXPECT_THAT(List(filter), ElementsAre());
}

TEST_F(SessionStoreTest, FinishesWhereTheLogEndsWithoutHoles) {
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, ScanRecords(1, 5)));
  ASSERT_OK(Append(session, {ScanRecord(7)}));
  EXPECT_STATUS(sessions_.Finish(Soon(), site_, session, 7), absl::StatusCode::kFailedPrecondition,
                HasSubstr("record 6 is missing"));
  ASSERT_OK(Append(session, {ScanRecord(6)}));
  EXPECT_STATUS(sessions_.Finish(Soon(), site_, session, 8), absl::StatusCode::kFailedPrecondition,
                HasSubstr("highest that is stored is 7"));
  ASSERT_OK_AND_ASSIGN(const storage::Session finished, sessions_.Finish(Soon(), site_, session, 7));
  EXPECT_EQ(finished.state, storage::SessionState::kFinished);
  ASSERT_TRUE(finished.finish_time);
  ASSERT_OK_AND_ASSIGN(const storage::Session again, sessions_.Finish(Soon(), site_, session, 7));
  EXPECT_EQ(again.finish_time, finished.finish_time);
  EXPECT_CODE(sessions_.Finish(Soon(), site_, SessionId("s9"), 0), absl::StatusCode::kNotFound);
}

TEST_F(SessionStoreTest, WithoutAMapThereIsNothingLeftToDo) {
  const SessionId session = NewSession("s1", false);
  ASSERT_OK_AND_ASSIGN(const storage::Session finished, sessions_.Finish(Soon(), site_, session, 0));
  EXPECT_EQ(finished.state, storage::SessionState::kMapped);
}

TEST_F(SessionStoreTest, DeletingIsSeenAtOnceAndForGood) {
  const SessionId session = NewSession("s1");
  NewSession("s2");
  ASSERT_OK(Append(session, ScanRecords(1, 5)));
  ASSERT_OK(sessions_.Delete(Soon(), site_, session));
  EXPECT_CODE(sessions_.Get(Soon(), site_, session), absl::StatusCode::kNotFound);
  EXPECT_THAT(List({}), ElementsAre("s2"));
  EXPECT_CODE(records_.Read(Soon(), site_, session, 1, 1000), absl::StatusCode::kNotFound);
  EXPECT_CODE(sessions_.Finish(Soon(), site_, session, 5), absl::StatusCode::kNotFound);
  EXPECT_CODE(sessions_.Delete(Soon(), site_, session), absl::StatusCode::kNotFound);
  EXPECT_STATUS(sessions_.Create(Soon(), MakeSession(site_, session, robot_, map_), ""),
                absl::StatusCode::kAlreadyExists, HasSubstr("deleted"));
}

TEST_F(SessionStoreTest, PagesOfEverySizeListEachSessionOnce) {
  std::vector<std::string> expected;
  for (int i = 0; i < 7; ++i) {
    NewSession("s" + std::to_string(i));
    expected.insert(expected.begin(), "s" + std::to_string(i));
  }
  for (int limit = 1; limit <= 8; ++limit) {
    std::vector<std::string> listed;
    std::optional<storage::SessionPosition> after;
    while (true) {
      ASSERT_OK_AND_ASSIGN(const auto page, sessions_.List(Soon(), site_, {}, limit, after));
      if (page.empty()) break;
      ASSERT_LE(page.size(), static_cast<std::size_t>(limit));
      for (const storage::Session& session : page) listed.push_back(session.id.value());
      after = storage::SessionPosition{page.back().create_time, page.back().id};
    }
    EXPECT_EQ(listed, expected) << limit;
  }
  ASSERT_OK_AND_ASSIGN(const auto elsewhere, sessions_.List(Soon(), SiteId("nowhere"), {}, 10, std::nullopt));
  EXPECT_TRUE(elsewhere.empty());
}

TEST_F(SessionStoreTest, AFinishedSessionKeepsItsTimeAndTakesNoOtherEnd) {
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, ScanRecords(1, 2)));
  ASSERT_OK(sessions_.Finish(Soon(), site_, session, 2));
  EXPECT_CODE(sessions_.Finish(Soon(), site_, session, 1), absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(sessions_.Finish(Soon(), site_, session, 3), absl::StatusCode::kFailedPrecondition);
  storage::SessionFilter finished;
  finished.state = storage::SessionState::kFinished;
  EXPECT_THAT(List(finished), ElementsAre("s1"));
}

TEST_F(SessionStoreTest, AnIdleSessionIsClosedAsFarAsItWasRecorded) {
  const SessionId mapped = NewSession("mapped");
  const SessionId recorded = NewSession("recorded", false);
  const SessionId holed = NewSession("holed");
  const SessionId finished = NewSession("finished", false);
  ASSERT_OK(Append(mapped, ScanRecords(1, 3)));
  ASSERT_OK(Append(holed, ScanRecords(1, 3)));
  ASSERT_OK(Append(holed, {ScanRecord(5)}));
  ASSERT_OK_AND_ASSIGN(const storage::Session before, sessions_.Finish(Soon(), site_, finished, 0));
  ASSERT_OK_AND_ASSIGN(const auto nothing, sessions_.CloseIdle(Soon(), std::chrono::hours(1), 100));
  EXPECT_EQ(nothing.finished + nothing.failed, 0) << "they were active just now";
  ASSERT_OK_AND_ASSIGN(const auto closed, sessions_.CloseIdle(Soon(), std::chrono::seconds(0), 100));
  EXPECT_EQ(closed.finished, 2);
  EXPECT_EQ(closed.failed, 1);

  const auto get = [&](const SessionId& id) { return *sessions_.Get(Soon(), site_, id); };
  EXPECT_EQ(get(mapped).state, storage::SessionState::kFinished);
  EXPECT_EQ(get(recorded).state, storage::SessionState::kMapped) << "there is nothing to map";
  EXPECT_EQ(get(holed).state, storage::SessionState::kFailed);
  EXPECT_THAT(get(holed).error, HasSubstr("record 4 is missing"));
  EXPECT_EQ(get(finished).finish_time, before.finish_time);
  for (const SessionId& id : {mapped, recorded, holed}) {
    EXPECT_TRUE(get(id).finish_time) << id.value();
    EXPECT_CODE(Append(id, {ScanRecord(9)}), absl::StatusCode::kFailedPrecondition) << id.value();
  }
  EXPECT_OK(Append(mapped, ScanRecords(1, 3))) << "what is stored may be sent again";
  ASSERT_OK_AND_ASSIGN(const auto leased, mapping_.Acquire(Soon(), "worker", std::chrono::seconds(60)));
  ASSERT_TRUE(leased.has_value());
  EXPECT_EQ(leased->session.id, mapped) << "to be closed";
  EXPECT_OK(mapping_.Release(Soon(), leased->lease, 0));
}

TEST_F(SessionStoreTest, IdleSessionsAreClosedInPortions) {
  for (int i = 0; i < 5; ++i) NewSession(fmt::format("s{}", i), false);
  ASSERT_OK_AND_ASSIGN(const auto first, sessions_.CloseIdle(Soon(), std::chrono::seconds(0), 3));
  EXPECT_EQ(first.finished, 3);
  ASSERT_OK_AND_ASSIGN(const auto rest, sessions_.CloseIdle(Soon(), std::chrono::seconds(0), 3));
  EXPECT_EQ(rest.finished, 2);
}

TEST_F(SessionStoreTest, RefusesAnEntryPoseWithAnInvalidCovariance) {
  storage::Session session = MakeSession(site_, SessionId("s1"), robot_, map_);
  session.entry.T_map_robot = PoseWithCovariance{{}, Eigen::Vector3d(1, 1, -1).asDiagonal()};
  EXPECT_STATUS(sessions_.Create(Soon(), session, ""), absl::StatusCode::kInvalidArgument,
                HasSubstr("entry.pose_map_robot"));
  EXPECT_THAT(List({}), ElementsAre());
}

TEST_F(SessionStoreTest, ARequestIdBelongsToItsSite) {
  backend_->AddSite(SiteId("other"));
  backend_->AddRobot(SiteId("other"), robot_);
  ASSERT_OK(sessions_.Create(Soon(), MakeSession(site_, SessionId("a"), robot_, map_), "request"));
  ASSERT_OK_AND_ASSIGN(
      const storage::Session other,
      sessions_.Create(Soon(), MakeSession(SiteId("other"), SessionId("b"), robot_, std::nullopt), "request"));
  EXPECT_EQ(other.id, SessionId("b"));
  // Of a deleted session it does not come back.
  ASSERT_OK(sessions_.Delete(Soon(), site_, SessionId("a")));
  EXPECT_CODE(sessions_.Create(Soon(), MakeSession(site_, SessionId("c"), robot_, map_), "request"),
              absl::StatusCode::kAlreadyExists);
}

TEST_F(SessionStoreTest, ARequestIdThatWasUsedForSomethingElseIsRefused) {
  const storage::RequestId request("request", std::string(32, 'a'));
  const storage::RequestId other("request", std::string(32, 'b'));
  ASSERT_OK(sessions_.Create(Soon(), MakeSession(site_, SessionId("r1"), robot_, map_), request));
  EXPECT_OK(sessions_.Create(Soon(), MakeSession(site_, SessionId("r2"), robot_, map_), request));
  EXPECT_CODE(sessions_.Create(Soon(), MakeSession(site_, SessionId("r3"), robot_, map_), other).status(),
              absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace enfilade::testing
