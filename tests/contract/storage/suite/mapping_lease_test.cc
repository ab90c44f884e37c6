// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <thread>

#include "fmt/format.h"
#include "tests/contract/storage/suite/mapping_fixture.h"

namespace enfilade::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;

TEST_F(MappingStoreTest, ThereIsWorkWhereRecordsAreNotMappedOrASessionIsToBeClosed) {
  NewSession("empty");
  EXPECT_OK(Append(NewSession("recorded", false), ScanRecords(1, 3)));
  EXPECT_FALSE(FindsWork());
  const SessionId session = SessionWithRecords("s1", 3);
  const storage::LeasedSession leased = AcquireOne();
  EXPECT_EQ(leased.session.id, session);
  EXPECT_EQ(leased.session.acknowledged_sequence, 3);
  EXPECT_EQ(leased.lease.token, 1);
  EXPECT_FALSE(FindsWork());
  ASSERT_OK(CommitStep(leased.lease, {}, 3));
  ASSERT_OK(mapping_.Release(Soon(), leased.lease, 0));
  EXPECT_FALSE(FindsWork());
  ASSERT_OK(sessions_.Finish(Soon(), site_, session, 3));
  EXPECT_TRUE(FindsWork());
}

TEST_F(MappingStoreTest, ASessionThatWaitsForItsMapIsMappedOnceItIsKnown) {
  const SessionId previous = NewSession("s1");
  ASSERT_OK(sessions_.Finish(Soon(), site_, previous, 0));
  storage::Session waiting = MakeSession(site_, SessionId("s2"), robot_, std::nullopt);
  waiting.entry.previous = previous;
  ASSERT_OK(sessions_.Create(Soon(), waiting, ""));
  ASSERT_OK(Append(waiting.id, ScanRecords(1, 3)));
  const storage::LeasedSession closing = AcquireOne();
  EXPECT_EQ(closing.session.id, previous) << "the only one that can be mapped";
  EXPECT_FALSE(FindsWork());
  ASSERT_OK_AND_ASSIGN(const storage::Session finished, sessions_.Finish(Soon(), site_, waiting.id, 3));
  EXPECT_EQ(finished.state, storage::SessionState::kFinished);
  EXPECT_FALSE(FindsWork());
  backend_->EnterMap(site_, waiting.id, map_, {{1, 2, 0.5}, Eigen::Matrix3d::Identity()});
  const storage::LeasedSession leased = AcquireOne();
  EXPECT_EQ(leased.session.id, waiting.id);
  EXPECT_EQ(leased.session.map, map_);
  ASSERT_TRUE(leased.session.entry.T_map_robot);
  EXPECT_EQ(leased.session.entry.T_map_robot->pose, (Pose2{1, 2, 0.5}));
}

TEST_F(MappingStoreTest, ALeaseThatRanOutGoesToAnotherWithAHigherToken) {
  const SessionId session = SessionWithRecords("s1", 3);
  const storage::LeasedSession lost = AcquireOne("first", milliseconds(1));
  std::this_thread::sleep_for(milliseconds(5));
  const storage::LeasedSession held = AcquireOne("second");
  EXPECT_EQ(held.lease.session, session);
  EXPECT_GT(held.lease.token, lost.lease.token);
  EXPECT_STATUS(CommitStep(lost.lease, FirstDelta(), 3), absl::StatusCode::kAborted, HasSubstr("first"));
  EXPECT_CODE(mapping_.Renew(Soon(), lost.lease, seconds(60)), absl::StatusCode::kAborted);
  EXPECT_OK(mapping_.Release(Soon(), lost.lease, 0));
  EXPECT_FALSE(FindsWork());
  EXPECT_OK(CommitStep(held.lease, FirstDelta(), 3));
}

TEST_F(MappingStoreTest, ALeaseThatRanOutStillHoldsWhileNobodyElseTookIt) {
  SessionWithRecords("s1", 3);
  const storage::LeasedSession leased = AcquireOne("first", milliseconds(1));
  std::this_thread::sleep_for(milliseconds(5));
  EXPECT_OK(CommitStep(leased.lease, FirstDelta(), 3));
  EXPECT_OK(mapping_.Renew(Soon(), leased.lease, seconds(60)));
  EXPECT_OK(Append(leased.session.id, {ScanRecord(4)}));
  EXPECT_FALSE(FindsWork());
}

TEST_F(MappingStoreTest, AReleasedSessionGoesToTheEndOfTheQueue) {
  SessionWithRecords("s1", 3);
  SessionWithRecords("s2", 3);
  const storage::LeasedSession first = AcquireOne();
  ASSERT_OK(mapping_.Release(Soon(), first.lease, 0));
  EXPECT_NE(AcquireOne().session.id, first.session.id);
  EXPECT_EQ(AcquireOne().session.id, first.session.id);
}

TEST_F(MappingStoreTest, AttemptsAreCountedUntilALeaseIsReleased) {
  SessionWithRecords("s1", 3);
  for (std::int64_t attempt = 1; attempt <= 3; ++attempt) {
    EXPECT_EQ(AcquireOne("dies", milliseconds(1)).attempts, attempt);
    std::this_thread::sleep_for(milliseconds(5));
  }
  const storage::LeasedSession survivor = AcquireOne();
  EXPECT_EQ(survivor.attempts, 4);
  ASSERT_OK(mapping_.Release(Soon(), survivor.lease, 0));
  EXPECT_EQ(AcquireOne().attempts, 1);
}

TEST_F(MappingStoreTest, EachSessionGoesToOneOfManyWorkers) {
  constexpr int kSessions = 12;
  for (int i = 0; i < kSessions; ++i) SessionWithRecords(fmt::format("s{}", i), 1);
  std::atomic<int> leases = 0;
  std::vector<std::thread> workers;
  for (int w = 0; w < 4; ++w) {
    workers.emplace_back([&, w] {
      // Losing a race for the candidates is no reason to stop.
      for (int misses = 0; misses < 20;) {
        const auto leased = mapping_.Acquire(Soon(), fmt::format("w{}", w), seconds(60));
        ASSERT_OK(leased);
        if (leased->has_value()) {
          ++leases;
          EXPECT_EQ((*leased)->lease.token, 1);
        } else {
          ++misses;
        }
      }
    });
  }
  for (std::thread& worker : workers) worker.join();
  EXPECT_EQ(leases, kSessions);
}

TEST_F(MappingStoreTest, ARecordThatComesAfterTheLastReadKeepsTheSessionWaiting) {
  const SessionId session = SessionWithRecords("s1", 3);
  const storage::LeasedSession leased = AcquireOne();
  ASSERT_OK(CommitStep(leased.lease, {}, 3));
  ASSERT_OK(Append(session, {ScanRecord(4)}));
  ASSERT_OK(mapping_.Release(Soon(), leased.lease, 3));
  EXPECT_TRUE(FindsWork());
}

TEST_F(MappingStoreTest, ASessionWhoseRecordsAreReadWaitsForMoreOrItsEnd) {
  const SessionId session = SessionWithRecords("s1", 3);
  ASSERT_OK(mapping_.Release(Soon(), AcquireOne().lease, 3));
  EXPECT_FALSE(FindsWork()) << "nothing is mapped, and more has to come first";
  ASSERT_OK(Append(session, {ScanRecord(4)}));
  ASSERT_OK(mapping_.Release(Soon(), AcquireOne().lease, 4));
  EXPECT_FALSE(FindsWork());
  ASSERT_OK(sessions_.Finish(Soon(), site_, session, 4));
  ASSERT_OK(mapping_.Release(Soon(), AcquireOne().lease, 4));
  EXPECT_TRUE(FindsWork()) << "it has to be closed";
}

TEST_F(MappingStoreTest, WhatWasReadButNotStoredIsFoundAgainOnceItIsQueued) {
  const SessionId session = SessionWithRecords("s1", 3);
  ASSERT_OK(mapping_.Release(Soon(), AcquireOne().lease, 3));
  EXPECT_FALSE(FindsWork());
  ASSERT_OK(mapping_.Queue(Soon(), site_, session));
  ASSERT_OK(mapping_.Queue(Soon(), site_, session)) << "again";
  const storage::LeasedSession leased = AcquireOne();
  EXPECT_EQ(leased.session.id, session);
  ASSERT_OK(CommitStep(leased.lease, {}, 3));
  ASSERT_OK(mapping_.Release(Soon(), leased.lease, 3));
  ASSERT_OK(mapping_.Queue(Soon(), site_, session));
  EXPECT_FALSE(FindsWork()) << "all is stored";
  EXPECT_OK(mapping_.Queue(Soon(), site_, SessionId("none")));
}

TEST_F(MappingStoreTest, NoRecordIsForgottenWhileOthersAreMapped) {
  constexpr std::int64_t kRecords = 200;
  const SessionId session = NewSession("s1");
  std::atomic<bool> recorded = false;
  std::thread robot([&] {
    for (std::int64_t i = 1; i <= kRecords; ++i) EXPECT_OK(Append(session, {ScanRecord(i)}));
    recorded = true;
  });
  for (bool last_look = false; !last_look;) {
    last_look = recorded;
    const auto leased = mapping_.Acquire(Soon(), "worker", seconds(60));
    ASSERT_OK(leased);
    if (!leased->has_value()) continue;
    last_look = false;
    const std::int64_t read = (*leased)->session.acknowledged_sequence;
    ASSERT_OK(CommitStep((*leased)->lease, {}, read));
    ASSERT_OK(mapping_.Release(Soon(), (*leased)->lease, read));
  }
  robot.join();
  ASSERT_OK_AND_ASSIGN(const storage::Session mapped, sessions_.Get(Soon(), site_, session));
  EXPECT_EQ(mapped.mapped_sequence, kRecords);
}

TEST_F(MappingStoreTest, TheBacklogHasTheSessionsThatWait) {
  NewSession("idle");
  ASSERT_OK_AND_ASSIGN(const storage::MappingBacklog nothing, mapping_.GetBacklog(Soon()));
  EXPECT_EQ(nothing.sessions, 0);
  EXPECT_EQ(nothing.oldest_s, 0.0);
  SessionWithRecords("s1", 3);
  SessionWithRecords("s2", 3);
  ASSERT_OK_AND_ASSIGN(const storage::MappingBacklog before, mapping_.GetBacklog(Soon()));
  EXPECT_EQ(before.sessions, 2);
  EXPECT_GT(before.oldest_s, 0.0);
  const storage::LeasedSession leased = AcquireOne();
  ASSERT_OK(CommitStep(leased.lease, {}, 3));
  ASSERT_OK(mapping_.Release(Soon(), leased.lease, 3));
  ASSERT_OK_AND_ASSIGN(const storage::MappingBacklog after, mapping_.GetBacklog(Soon()));
  EXPECT_EQ(after.sessions, 1);
}

TEST_F(MappingStoreTest, TheBacklogHasTheSessionsThatWaitForTheirMap) {
  const SessionId previous = NewSession("s1");
  storage::Session next = MakeSession(site_, SessionId("s2"), robot_, std::nullopt);
  next.entry.previous = previous;
  ASSERT_OK(sessions_.Create(Soon(), next, ""));
  ASSERT_OK_AND_ASSIGN(const storage::MappingBacklog before, mapping_.GetBacklog(Soon()));
  EXPECT_EQ(before.without_map, 0) << "the robot may still be before the door";
  ASSERT_OK(sessions_.Finish(Soon(), site_, previous, 0));
  ASSERT_OK_AND_ASSIGN(const storage::MappingBacklog after, mapping_.GetBacklog(Soon()));
  EXPECT_EQ(after.without_map, 1);
  EXPECT_GT(after.longest_without_map_s, 0.0);
  ASSERT_OK(sessions_.Delete(Soon(), site_, SessionId("s2")));
  ASSERT_OK_AND_ASSIGN(const storage::MappingBacklog deleted, mapping_.GetBacklog(Soon()));
  EXPECT_EQ(deleted.without_map, 0);
}

TEST_F(MappingStoreTest, DeletingTheSessionTakesTheLeaseAway) {
  const SessionId session = SessionWithRecords("s1", 3);
  const storage::LeasedSession leased = AcquireOne();
  ASSERT_OK(CommitStep(leased.lease, FirstDelta(), 1));
  ASSERT_OK(sessions_.Delete(Soon(), site_, session));
  EXPECT_CODE(CommitStep(leased.lease, {}, 2), absl::StatusCode::kAborted);
  EXPECT_CODE(mapping_.Renew(Soon(), leased.lease, seconds(60)), absl::StatusCode::kAborted);
  EXPECT_OK(mapping_.Release(Soon(), leased.lease, 0));
  EXPECT_FALSE(FindsWork());
  EXPECT_CODE(mapping_.ReadTrajectory(Soon(), site_, session), absl::StatusCode::kNotFound);
}

TEST_F(MappingStoreTest, TheSessionThatHasWaitedLongestComesFirst) {
  for (const char* id : {"c", "a", "b"}) SessionWithRecords(id, 1);
  std::vector<std::string> order;
  std::vector<storage::LeasedSession> leased;
  for (int i = 0; i < 3; ++i) {
    leased.push_back(AcquireOne());
    order.push_back(leased.back().session.id.value());
  }
  EXPECT_EQ(order, (std::vector<std::string>{"c", "a", "b"})) << "in the order of their creation";
  // Given back in another order: that is how long they have been waiting now.
  for (const int i : {1, 2, 0}) ASSERT_OK(mapping_.Release(Soon(), leased[static_cast<std::size_t>(i)].lease, 0));
  order.clear();
  for (int i = 0; i < 3; ++i) order.push_back(AcquireOne().session.id.value());
  EXPECT_EQ(order, (std::vector<std::string>{"a", "b", "c"}));
}

TEST_F(MappingStoreTest, AnExpiredLeaseOfTheSameOwnerIsAnotherLease) {
  SessionWithRecords("s1", 1);
  const storage::LeasedSession first = AcquireOne("worker", milliseconds(1));
  std::this_thread::sleep_for(milliseconds(5));
  const storage::LeasedSession second = AcquireOne("worker");
  EXPECT_EQ(second.lease.token, first.lease.token + 1);
  EXPECT_CODE(mapping_.Renew(Soon(), first.lease, seconds(60)), absl::StatusCode::kAborted);
  EXPECT_OK(mapping_.Release(Soon(), first.lease, 0));
  EXPECT_OK(mapping_.Renew(Soon(), second.lease, seconds(60)));
}

TEST_F(MappingStoreTest, AMappedSessionIsNotAcquiredAgain) {
  const SessionId session = SessionWithRecords("s1", 2);
  ASSERT_OK(sessions_.Finish(Soon(), site_, session, 2));
  const storage::LeasedSession leased = AcquireOne();
  const slam::SlamDelta delta = FirstDelta();
  storage::MappingStep step = StepOf(delta, "c", 2);
  step.final_state = storage::SessionState::kRecording;
  EXPECT_CODE(mapping_.Commit(Soon(), leased.lease, step), absl::StatusCode::kInvalidArgument);
  step.final_state = storage::SessionState::kMapped;
  ASSERT_OK_AND_ASSIGN(const std::int64_t number, mapping_.Commit(Soon(), leased.lease, step));
  EXPECT_EQ(number, 0) << "no revision came with it";
  ASSERT_OK(mapping_.Release(Soon(), leased.lease, 0));
  EXPECT_FALSE(FindsWork());
  ASSERT_OK_AND_ASSIGN(const storage::Map map, maps_.Get(Soon(), site_, map_));
  EXPECT_EQ(map.state, storage::MapState::kEmpty) << "a map without a revision stays empty";
}

}  // namespace
}  // namespace enfilade::testing
