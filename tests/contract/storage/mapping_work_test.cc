// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/mapping_work.h"

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "fmt/format.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using std::chrono::seconds;

class MappingWorkTest : public StoreTest {
 protected:
  // Sessions whose records are mapped, after somebody held and released them.
  void AddIdleSessions(int first, int last) {
    database_.Sql(
        fmt::format("INSERT INTO enfilade.sessions (site_id, session_id, robot_id, map_id, acknowledged_sequence,"
                    " highest_sequence, laser_scans) SELECT 'campus', 'idle' || i, 'r1', 'hall', 5, 5, 5"
                    " FROM generate_series({}, {}) i",
                    first, last));
    database_.Sql(
        fmt::format("INSERT INTO enfilade.mapping_checkpoints (site_id, session_id, mapped_sequence, token, paired,"
                    " unpaired, time_reversed, used, keyframes, lost, state)"
                    " SELECT 'campus', 'idle' || i, 5, 1, 5, 0, 0, 5, 1, 0, '' FROM generate_series({}, {}) i",
                    first, last));
    database_.Sql(
        fmt::format("INSERT INTO enfilade.session_leases (site_id, session_id, owner, token, expires_at)"
                    " SELECT 'campus', 'idle' || i, '', 1, now() - interval '1 minute'"
                    " FROM generate_series({}, {}) i",
                    first, last));
    database_.Sql("ANALYZE enfilade.sessions, enfilade.mapping_checkpoints, enfilade.session_leases");
  }
  // The rows of all tables that one look for work reads. It finds `expected`.
  std::int64_t RowsReadByALook(const SessionId& expected) {
    const std::int64_t before = RowsRead();
    {
      storage::postgres::PoolOptions options;
      options.url = database_.url();
      options.application_name = "looks-for-work";
      auto pool = storage::postgres::Pool::Create(options);
      EXPECT_OK(pool);
      const auto leased = storage::postgres::MappingStore(**pool).Acquire(Soon(), "worker", seconds(60));
      EXPECT_OK(leased);
      EXPECT_EQ((*leased)->session.id, expected);
    }
    // A connection hands in its statistics when it ends.
    Await("SELECT count(*) = 0 FROM pg_stat_activity WHERE application_name = 'looks-for-work'");
    return RowsRead() - before;
  }
  std::int64_t RowsRead() const {
    return std::stoll(
        database_.SqlValue("SELECT sum(coalesce(seq_tup_read, 0) + coalesce(idx_tup_fetch, 0))::bigint"
                           " FROM pg_stat_user_tables WHERE schemaname = 'enfilade'"));
  }
  void Await(const std::string& condition) const {
    while (database_.SqlValue(condition) != "t") std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  void AwaitLockWaits(int count) const {
    Await(
        fmt::format("SELECT count(*) = {} FROM pg_stat_activity WHERE wait_event_type = 'Lock'"
                    " AND datname = current_database()",
                    count));
  }
  // Runs both while another transaction locks the session's row: `first` comes first when it is free.
  void RunInOrder(const SessionId& session, const std::function<void()>& first, const std::function<void()>& second) {
    auto blocker = storage::postgres::Transaction::Begin(*pool_, Soon());
    ASSERT_OK(blocker);
    ASSERT_OK(blocker->Execute({"blocking",
                                "SELECT FROM enfilade.sessions WHERE site_id = $1 AND session_id = $2"
                                " FOR UPDATE"},
                               storage::postgres::Params(site_, session)));
    std::thread one(first);
    AwaitLockWaits(1);
    std::thread two(second);
    AwaitLockWaits(2);
    ASSERT_OK(blocker->Commit());
    one.join();
    two.join();
  }
  // A session with three records, all of them mapped, which is still held.
  storage::LeasedSession HoldMappedSession() {
    EXPECT_OK(Append(NewSession("s1"), ScanRecords(1, 3)));
    const auto leased = mapping_.Acquire(Soon(), "worker", seconds(60));
    EXPECT_OK(leased);
    const slam::SlamDelta delta;
    EXPECT_OK(mapping_.Commit(Soon(), (*leased)->lease, StepOf(delta, "c", 3)));
    return **leased;
  }
  std::string Work(const std::string& columns = "count(*)") const {
    return database_.SqlValue("SELECT " + columns + " FROM enfilade.mapping_work");
  }
  bool FindsWork() {
    const auto leased = mapping_.Acquire(Soon(), "another", seconds(60));
    EXPECT_OK(leased);
    return leased->has_value();
  }
};

TEST_F(MappingWorkTest, ALookReadsAsManyRowsHoweverManySessionsAreIdle) {
  AddIdleSessions(1, 10);
  const SessionId one = NewSession("one");
  ASSERT_OK(Append(one, ScanRecords(1, 3)));
  const std::int64_t with_ten = RowsReadByALook(one);
  AddIdleSessions(11, 10'000);
  const SessionId other = NewSession("other");
  ASSERT_OK(Append(other, ScanRecords(1, 3)));
  const std::int64_t with_ten_thousand = RowsReadByALook(other);
  EXPECT_GT(with_ten, 0);
  EXPECT_LE(with_ten_thousand, with_ten + 10);
}

TEST_F(MappingWorkTest, RecordsOfASessionThatWaitsAlreadyWriteNothing) {
  const SessionId session = NewSession("s1");
  ASSERT_OK(Append(session, ScanRecords(1, 3)));
  const std::string row = Work("ctid || ' ' || xmin::text");
  for (std::int64_t i = 4; i < 20; ++i) ASSERT_OK(Append(session, {ScanRecord(i)}));
  EXPECT_EQ(Work("ctid || ' ' || xmin::text"), row);
  EXPECT_EQ(Work("pg_relation_size('enfilade.mapping_work')"), "8192");
}

TEST_F(MappingWorkTest, ARecordThatIsStoredWhileTheTurnEndsIsFoundInEitherOrder) {
  const storage::LeasedSession leased = HoldMappedSession();
  const auto append = [&](std::int64_t sequence) {
    return [this, &leased, sequence] { EXPECT_OK(Append(leased.session.id, {ScanRecord(sequence)})); };
  };
  const auto release = [this, &leased] { EXPECT_OK(mapping_.Release(Soon(), leased.lease, 3)); };
  RunInOrder(leased.session.id, append(4), release);
  ASSERT_OK_AND_ASSIGN(const auto again, mapping_.Acquire(Soon(), "worker", seconds(60)));
  ASSERT_TRUE(again.has_value()) << "the record came first";
  const slam::SlamDelta delta;
  ASSERT_OK(mapping_.Commit(Soon(), again->lease, StepOf(delta, "c", 4)));
  RunInOrder(
      leased.session.id, [&] { EXPECT_OK(mapping_.Release(Soon(), again->lease, 4)); }, append(5));
  EXPECT_TRUE(FindsWork()) << "the turn ended first";
}

TEST_F(MappingWorkTest, WhatCameDuringATurnHasWaitedSinceItsBegin) {
  const storage::LeasedSession leased = HoldMappedSession();
  const std::string waiting_since = Work("waiting_since");
  ASSERT_OK(Append(leased.session.id, {ScanRecord(4)}));
  ASSERT_OK(mapping_.Release(Soon(), leased.lease, 3));
  EXPECT_NE(Work("waiting_since"), waiting_since) << "what had waited before is mapped";
  EXPECT_EQ(
      Work(fmt::format("(extract(epoch FROM waiting_since) * 1000000)::bigint = {}", leased.lease.take_time / 1000)),
      "t");
  ASSERT_OK(Append(leased.session.id, {ScanRecord(5)}));
  ASSERT_OK_AND_ASSIGN(const auto again, mapping_.Acquire(Soon(), "worker", seconds(60)));
  const std::string unmapped_since = Work("waiting_since");
  ASSERT_OK(mapping_.Release(Soon(), again->lease, 0));
  EXPECT_EQ(Work("waiting_since"), unmapped_since) << "nothing was mapped in this turn";
}

TEST_F(MappingWorkTest, WhatWasRecordedBehindADoorHasWaitedSinceItsSessionBegan) {
  storage::Session behind = MakeSession(site_, SessionId("behind"), robot_, std::nullopt);
  behind.entry.previous = NewSession("s1");
  ASSERT_OK(sessions_.Create(Soon(), behind, ""));
  ASSERT_OK(Append(behind.id, ScanRecords(1, 3)));
  ASSERT_EQ(Work(), "0");
  database_.Sql(
      "UPDATE enfilade.sessions SET map_id = 'hall', create_time = now() - interval '1 hour'"
      " WHERE session_id = 'behind'");
  ASSERT_OK_AND_ASSIGN(auto transaction, storage::postgres::Transaction::Begin(*pool_, Soon()));
  storage::postgres::QueueEnteredSessions(transaction, site_, *behind.entry.previous);
  ASSERT_OK(transaction.Commit());
  EXPECT_EQ(Work("now() - waiting_since >= interval '1 hour'"), "t");
}

TEST_F(MappingWorkTest, DeletedSessionsLeaveNothingBehindAndHoldUpNobody) {
  for (int i = 0; i < 20; ++i) {
    const SessionId session = NewSession(fmt::format("deleted{}", i));
    ASSERT_OK(Append(session, ScanRecords(1, 3)));
    ASSERT_OK(sessions_.Delete(Soon(), site_, session));
  }
  const SessionId kept = NewSession("kept");
  ASSERT_OK(Append(kept, ScanRecords(1, 3)));
  ASSERT_OK_AND_ASSIGN(const auto leased, mapping_.Acquire(Soon(), "worker", seconds(60)));
  ASSERT_TRUE(leased.has_value());
  EXPECT_EQ(leased->session.id, kept);
  EXPECT_EQ(Work("string_agg(session_id, ' ')"), "kept");
}

}  // namespace
}  // namespace enfilade::testing
