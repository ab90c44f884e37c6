// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <future>
#include <stop_token>
#include <thread>

#include "storage/postgres/driver/copy_buffer.h"
#include "storage/postgres/driver/transaction.h"
#include "tests/support/database.h"
#include "tests/support/status_assertions.h"

namespace enfilade::storage::postgres {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using ::testing::HasSubstr;

constexpr Statement kOwnPid{"reading the pid", "SELECT pg_backend_pid()::bigint"};
constexpr Statement kSelect{"selecting one", "SELECT 1::bigint"};
constexpr Statement kSleepLong{"sleeping", "SELECT pg_sleep(600)::text"};
constexpr Statement kSleepShort{"dozing", "SELECT pg_sleep($1)::text"};
constexpr Statement kAdd{"adding", "INSERT INTO t (k) VALUES ($1)"};
constexpr Statement kLockTable{"locking", "LOCK TABLE t IN ACCESS EXCLUSIVE MODE"};
constexpr Statement kCopyIn{"copying", "COPY t (k) FROM STDIN (FORMAT binary)"};

class CancellationTest : public enfilade::testing::DatabaseTest {
 protected:
  CancellationTest() { database_.Sql("CREATE TABLE t (k bigint PRIMARY KEY)"); }

  CallContext Cancellable(std::chrono::steady_clock::duration timeout = std::chrono::seconds(300)) const {
    CallContext context = CallContext::WithTimeout(timeout);
    context.cancellation = cancellation_.get_token();
    return context;
  }
  // Statements of other connections that are still running.
  std::string Running() const {
    return database_.SqlValue(
        "SELECT count(*) FROM pg_stat_activity"
        " WHERE datname = current_database() AND pid <> pg_backend_pid() AND state = 'active'");
  }
  // Runs `work` in a thread, and cancels it as soon as the database is at it.
  absl::Status CancelWhileRunning(const std::function<absl::Status()>& work) {
    std::future<absl::Status> done = std::async(std::launch::async, work);
    while (Running() != "1" && done.wait_for(milliseconds(5)) == std::future_status::timeout) {
    }
    cancellation_.request_stop();
    return done.get();
  }

  std::stop_source cancellation_;
};

TEST_F(CancellationTest, StopsAStatementAndKeepsTheConnection) {
  EXPECT_STATUS(CancelWhileRunning([&] { return ExecuteAlone(*pool_, Cancellable(), kSleepLong, Params()).status(); }),
                absl::StatusCode::kCancelled, HasSubstr("sleeping"));
  EXPECT_EQ(Running(), "0");
  EXPECT_OK(ExecuteAlone(*pool_, Soon(), kSelect, Params()));
  EXPECT_EQ(pool_->stats().opened, 1);
}

TEST_F(CancellationTest, StopsTheWaitForALockAndRollsTheTransactionBack) {
  ASSERT_OK_AND_ASSIGN(Transaction holder, Transaction::Begin(*pool_, Soon()));
  ASSERT_OK(holder.Execute(kAdd, Params(std::int64_t{1})));
  EXPECT_CODE(CancelWhileRunning([&]() -> absl::Status {
                auto waiting = Transaction::Begin(*pool_, Cancellable());
                if (!waiting.ok()) return waiting.status();
                if (auto status = waiting->Execute(kAdd, Params(std::int64_t{2})).status(); !status.ok()) return status;
                return waiting->Execute(kAdd, Params(std::int64_t{1})).status();  // waits for the holder
              }),
              absl::StatusCode::kCancelled);
  ASSERT_OK(holder.Commit());
  EXPECT_EQ(database_.SqlValue("SELECT string_agg(k::text, ' ') FROM t"), "1") << "2 has been rolled back";
  EXPECT_EQ(pool_->stats().open, 2) << "the cancelled connection is in use again";
}

TEST_F(CancellationTest, StopsWhateverStatementOfAFlushIsRunning) {
  EXPECT_STATUS(CancelWhileRunning([&]() -> absl::Status {
                  auto transaction = Transaction::Begin(*pool_, Cancellable());
                  if (!transaction.ok()) return transaction.status();
                  transaction->Queue(kAdd, Params(std::int64_t{1}));
                  transaction->Queue(kSleepLong, Params());
                  transaction->Queue(kAdd, Params(std::int64_t{2}));
                  return transaction->Commit();
                }),
                absl::StatusCode::kCancelled, HasSubstr("sleeping"));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM t"), "0");
  EXPECT_OK(ExecuteAlone(*pool_, Soon(), kSelect, Params()));
}

TEST_F(CancellationTest, StopsACopyThatWaits) {
  ASSERT_OK_AND_ASSIGN(Transaction holder, Transaction::Begin(*pool_, Soon()));
  ASSERT_OK(holder.Execute(kLockTable, Params()));
  CopyBuffer rows;
  rows.BeginRow(1);
  rows.Put(std::int64_t{7});
  const std::string data(rows.Finish());
  EXPECT_STATUS(CancelWhileRunning([&]() -> absl::Status {
                  auto transaction = Transaction::Begin(*pool_, Cancellable());
                  if (!transaction.ok()) return transaction.status();
                  return transaction->CopyIn(kCopyIn, data);
                }),
                absl::StatusCode::kCancelled, HasSubstr("copying"));
  ASSERT_OK(holder.Commit());
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM t"), "0");
}

// A request that reaches the database before the statement does is lost.
TEST_F(CancellationTest, IsRepeatedUntilTheStatementStops) {
  if (std::getenv("ENFILADE_TEST_DATABASE")) GTEST_SKIP() << "the server is not this test's own";
  ASSERT_OK_AND_ASSIGN(Transaction holder, Transaction::Begin(*pool_, Soon()));
  ASSERT_OK(holder.Execute(kLockTable, Params()));
  ASSERT_OK_AND_ASSIGN(Transaction waiting, Transaction::Begin(*pool_, Cancellable()));
  ASSERT_OK_AND_ASSIGN(const Result backend, waiting.Execute(kOwnPid, Params()));
  const auto pid = static_cast<pid_t>(Row(backend, 0).Int64());
  ASSERT_EQ(kill(pid, SIGSTOP), 0);
  cancellation_.request_stop();
  std::future<absl::Status> done = std::async(std::launch::async, [&] {
    return waiting.Execute(kAdd, Params(std::int64_t{1})).status();  // waits for the holder
  });
  std::this_thread::sleep_for(milliseconds(500));
  ASSERT_EQ(kill(pid, SIGCONT), 0);
  EXPECT_STATUS(done.get(), absl::StatusCode::kCancelled, HasSubstr("adding"));
  EXPECT_OK(holder.Commit()) << "it waited until the database ended the holder's transaction";
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM t"), "0");
}

TEST_F(CancellationTest, NeedsNoConnectionIfItComesFirst) {
  cancellation_.request_stop();
  EXPECT_CODE(ExecuteAlone(*pool_, Cancellable(), kSelect, Params()), absl::StatusCode::kCancelled);
  EXPECT_EQ(pool_->stats().opened, 0);
}

TEST_F(CancellationTest, EndsTheWaitForAConnection) {
  auto options = PoolOptions();
  options.url = database_.url();
  options.max_connections = 1;
  ASSERT_OK_AND_ASSIGN(const auto pool, Pool::Create(options));
  ASSERT_OK_AND_ASSIGN(const Pool::Lease only, pool->Acquire(Soon()));
  std::future<absl::Status> waiting =
      std::async(std::launch::async, [&] { return pool->Acquire(Cancellable()).status(); });
  while (pool->stats().waiting == 0) std::this_thread::yield();
  cancellation_.request_stop();
  EXPECT_CODE(waiting.get(), absl::StatusCode::kCancelled);
  EXPECT_EQ(pool->stats().waiting, 0);
}

TEST_F(CancellationTest, IsNotWhatADeadlineIsCalled) {
  EXPECT_CODE(ExecuteAlone(*pool_, Cancellable(milliseconds(200)), kSleepLong, Params()),
              absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(Running(), "0");
}

// However the request and the end of the statement fall together, the statement's caller gets an answer that is true,
// and the connection's next user is not disturbed.
TEST_F(CancellationTest, NeverHitsTheNextUserOfTheConnection) {
  for (int i = 0; i < 60; ++i) {
    std::stop_source source;
    CallContext context = Soon();
    context.cancellation = source.get_token();
    std::thread canceller([&source, i] {
      std::this_thread::sleep_for(std::chrono::microseconds(i * 1500));  // before and after the statement's end
      source.request_stop();
    });
    const absl::Status status = ExecuteAlone(*pool_, context, kSleepShort, Params(0.051)).status();
    if (!status.ok()) {
      EXPECT_CODE(status, absl::StatusCode::kCancelled);
    }
    EXPECT_OK(ExecuteAlone(*pool_, Soon(), kSleepShort, Params(0.001)));
    canceller.join();
  }
}

}  // namespace
}  // namespace enfilade::storage::postgres
