// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/mapping.h"

#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "fmt/format.h"
#include "tests/unit/server/app/mapping/mapping_workers.h"

namespace enfilade::server {
namespace {

using ::testing::HasSubstr;
using State = storage::SessionState;

TEST_F(MappingWorkersTest, MapsFinishedSessionsAndReportsTheirEnd) {
  const SessionId a = NewFinishedSession("a");
  ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "cellar"), ""));
  const SessionId b = NewFinishedSession("b", "cellar");
  Start();
  AwaitEnded(2);
  for (const SessionId& session : {a, b}) {
    EXPECT_EQ(Session(session).state, State::kMapped);
    ExpectOfflineMap(session);
  }
  mapping_.reset();
  EXPECT_EQ(metrics_->sessions_mapping(), 0);
}

TEST_F(MappingWorkersTest, SeveralWorkersMapManySessionsEachOnce) {
  std::vector<SessionId> sessions;
  for (int i = 0; i < 6; ++i) {
    const std::string id = std::to_string(i);
    ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "room" + id), ""));
    sessions.push_back(NewFinishedSession("s" + id, "room" + id));
  }
  Start(3);
  AwaitEnded(6);
  for (const SessionId& session : sessions) ExpectOfflineMap(session);
  EXPECT_EQ(ended_, 6);
}

TEST_F(MappingWorkersTest, AnUnreadableRecordFailsItsSessionAndNoOther) {
  const SessionId broken = NewFinishedSession("broken");
  stores_.database.CorruptRecord(site_, broken, 100);
  ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "room"), ""));
  const SessionId sound = NewFinishedSession("sound", "room");
  Start();
  AwaitEnded(2);
  EXPECT_EQ(Session(broken).state, State::kFailed);
  EXPECT_THAT(Session(broken).error, HasSubstr("broken"));
  EXPECT_EQ(Session(sound).state, State::kMapped);
}

TEST_F(MappingWorkersTest, AnExceptionEndsTheTurnAndTheTenthInSuccessionTheSession) {
  const SessionId poison = NewFinishedSession("poison");
  records_.ThrowFor(poison);
  ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "room"), ""));
  const SessionId sound = NewFinishedSession("sound", "room");
  Start();
  while (ended_ < 2) {
    stores_.database.AdvanceClock(std::chrono::hours(1));  // the leases of ended turns run out
    mapping_->Wake();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  AwaitState(sound, State::kMapped);
  EXPECT_EQ(Session(poison).state, State::kFailed);
  EXPECT_THAT(Session(poison).error, HasSubstr("bad_alloc"));
  EXPECT_EQ(records_.throws(), Mapping::kMaxAttempts);
}

TEST_F(MappingWorkersTest, ASessionThatKilledItsProcessesIsGivenUpUnread) {
  const SessionId deadly = NewFinishedSession("deadly");
  for (std::int64_t i = 0; i < Mapping::kMaxAttempts; ++i) {
    ASSERT_OK(stores_.mappings.Acquire(Soon(), "a process that dies", std::chrono::seconds(10)));
    stores_.database.AdvanceClock(std::chrono::hours(1));
  }
  Start();
  AwaitEnded(1);
  EXPECT_EQ(Session(deadly).state, State::kFailed);
  EXPECT_THAT(Session(deadly).error, HasSubstr("10 attempts"));
}

TEST_F(MappingWorkersTest, StoppingStoresTheCheckpointAndReleasesTheLease) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  Start();
  AwaitMapped(session, 100);
  Append(session, 100, 150);
  mapping_.reset();
  // Whether or not the last records were mapped before the stop: another process continues without waiting.
  Append(session, 150, Log().size());
  Finish(session);
  Start();
  AwaitState(session, State::kMapped);
  ExpectOfflineMap(session);
}

TEST_F(MappingWorkersTest, ContinuesFromTheCheckpointAfterAnOutage) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  Start();
  AwaitMapped(session, 100);
  stores_.database.FailCalls(absl::UnavailableError("gone"));
  mapping_->Wake();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  stores_.database.FailCalls(absl::OkStatus());
  Append(session, 100, Log().size());
  Finish(session);
  mapping_->Wake();
  AwaitState(session, State::kMapped);
  ExpectOfflineMap(session);
}

TEST_F(MappingWorkersTest, ASessionThatAnotherProcessMappedMeanwhileIsLoadedAgain) {
  const SessionId session = NewSession("s");
  Append(session, 0, 67);
  Start();
  AwaitMapped(session, 67);
  ASSERT_EQ(counting_.loads(), 1);
  // Another process takes the next turn.
  std::optional<storage::LeasedSession> taken;
  std::size_t end = 67;
  while (!taken) {
    Append(session, end, end + 1);
    ++end;
    const auto leased = stores_.mappings.Acquire(Soon(), "another process", std::chrono::hours(1));
    ASSERT_OK(leased);
    taken = *leased;  // unset: this process was faster
  }
  auto other = SessionMapping::Load(mapping_stores(), {}, taken->session);
  ASSERT_OK(other);
  while (*(*other)->Step(taken->lease) == SessionMapping::Progress::kWorked) {
  }
  ASSERT_OK((*other)->Store(taken->lease));
  ASSERT_OK(stores_.mappings.Release(Soon(), taken->lease, 0));
  Append(session, end, Log().size());
  Finish(session);
  mapping_->Wake();
  AwaitState(session, State::kMapped);
  ExpectOfflineMap(session);
  EXPECT_EQ(counting_.loads(), 2);
}

TEST_F(MappingWorkersTest, RecordsOfASessionThatIsBeingMappedCostNoLooks) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  records_.HoldUp(session);
  Start(2);
  while (!records_.is_waiting()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const int looks = counting_.looks();
  for (int i = 0; i < 300; ++i) {
    mapping_->Wake(site_, session);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_LT(counting_.looks() - looks, 50) << "those of the other worker that polls";
  Append(session, 100, Log().size());
  records_.LetGo();
  AwaitMapped(session, static_cast<std::int64_t>(Log().size()));
}

TEST_F(MappingWorkersTest, ManyRobotsCostFewLooks) {
  Start();
  for (int i = 0; i < 300; ++i) {
    mapping_->Wake(site_, SessionId(fmt::format("s{}", i)));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_LT(counting_.looks(), 50);
}

// The lease expires whenever another process gets hold of the clock: whoever loses it stores nothing more.
TEST_F(MappingWorkersTest, TheResultIsTheSameHoweverOftenLeasesAreLost) {
  const SessionId session = NewFinishedSession("s");
  options_.checkpoint_interval_s = 0.0;
  Start();
  for (int i = 0; i < 20 && Session(session).state != State::kMapped; ++i) {
    stores_.database.AdvanceClock(std::chrono::hours(1));
    const auto leased = stores_.mappings.Acquire(Soon(), "thief", std::chrono::seconds(10));
    ASSERT_OK(leased);
    if (!leased->has_value()) continue;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    ASSERT_OK(stores_.mappings.Release(Soon(), (*leased)->lease, 0));
    mapping_->Wake();
  }
  AwaitState(session, State::kMapped);
  ExpectOfflineMap(session);
}

}  // namespace
}  // namespace enfilade::server
