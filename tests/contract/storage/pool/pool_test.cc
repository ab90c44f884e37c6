// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/pool.h"

#include <atomic>
#include <csignal>
#include <thread>
#include <vector>

#include "storage/postgres/driver/error.h"
#include "storage/postgres/driver/transaction.h"
#include "tests/support/cluster.h"
#include "tests/support/database.h"
#include "tests/support/status_assertions.h"

namespace enfilade::storage::postgres {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr Statement kOne{"selecting one", "SELECT 1::bigint"};
constexpr Statement kSum{"adding", "SELECT $1 + $2"};

absl::Status Ping(Pool& pool) {
  return ExecuteAlone(pool, CallContext::WithTimeout(std::chrono::seconds(10)), kOne, Params()).status();
}

class PoolTest : public enfilade::testing::DatabaseTest {
 protected:
  std::unique_ptr<Pool> Make(PoolOptions options) {
    auto pool = Pool::Create(std::move(options));
    EXPECT_OK(pool);
    return *std::move(pool);
  }
  // Ends all connections to the database from outside.
  void TerminateBackends() {
    database_.Sql(
        "SELECT pg_terminate_backend(pid, 5000) FROM pg_stat_activity"
        " WHERE datname = current_database() AND pid <> pg_backend_pid()");
  }
};

TEST_F(PoolTest, RefusesMalformedOptions) {
  EXPECT_STATUS(Pool::Create({}), absl::StatusCode::kInvalidArgument, HasSubstr("url"));
  EXPECT_CODE(Pool::Create({.url = "postgresql://[half"}), absl::StatusCode::kInvalidArgument);
  EXPECT_STATUS(Pool::Create({.url = "postgresql:///x?no_such_option=1"}), absl::StatusCode::kInvalidArgument,
                HasSubstr("no_such_option"));
  EXPECT_STATUS(Pool::Create({.url = database_.url(), .max_connections = 0}), absl::StatusCode::kInvalidArgument,
                HasSubstr("max_connections"));
}

TEST_F(PoolTest, KeepsConnectionsForTheNextCaller) {
  for (int i = 0; i < 3; ++i) ASSERT_OK(Ping(*pool_));
  EXPECT_EQ(pool_->stats().opened, 1);
  EXPECT_EQ(pool_->stats().open, 1);
  EXPECT_EQ(pool_->stats().busy, 0);
}

TEST_F(PoolTest, RefusesACallWhoseDeadlineHasPassed) {
  for (const int connections : {0, 1}) {
    SCOPED_TRACE(connections);
    EXPECT_STATUS(ExecuteAlone(*pool_, CallContext::WithTimeout(-std::chrono::milliseconds(1)), kOne, Params()),
                  absl::StatusCode::kDeadlineExceeded, HasSubstr("has passed"));
    EXPECT_EQ(pool_->stats().opened, connections);
    EXPECT_EQ(pool_->stats().busy, 0);
    ASSERT_OK(Ping(*pool_));  // the second round finds an idle connection
  }
}

TEST_F(PoolTest, ServesManyThreadsWithFewConnections) {
  const auto pool = Make({.url = database_.url(), .max_connections = 3});
  std::atomic<int> right = 0;
  std::vector<std::thread> threads;
  for (std::int64_t t = 0; t < 12; ++t) {
    threads.emplace_back([&, t] {
      for (std::int64_t i = 0; i < 40; ++i) {
        const auto result = ExecuteAlone(*pool, Soon(), kSum, Params(t, i));
        if (result.ok() && Row(*result, 0).Int64() == t + i) ++right;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(right, 12 * 40);
  EXPECT_LE(pool->stats().opened, 3);
  EXPECT_EQ(pool->stats().busy, 0);
  EXPECT_EQ(pool->stats().waiting, 0);
}

TEST_F(PoolTest, SaysThatAllConnectionsAreBusy) {
  const auto pool = Make({.url = database_.url(), .max_connections = 1});
  ASSERT_OK_AND_ASSIGN(const Pool::Lease lease, pool->Acquire(Soon()));
  EXPECT_STATUS(pool->Acquire(CallContext::WithTimeout(std::chrono::milliseconds(20))),
                absl::StatusCode::kDeadlineExceeded, HasSubstr("busy"));
}

TEST_F(PoolTest, AWaitingCallerGetsTheConnectionThatComesBack) {
  const auto pool = Make({.url = database_.url(), .max_connections = 1});
  auto lease = std::make_unique<absl::StatusOr<Pool::Lease>>(pool->Acquire(Soon()));
  ASSERT_OK(*lease);
  absl::Status waited = absl::UnknownError("not yet");
  std::thread waiting([&] { waited = Ping(*pool); });
  while (pool->stats().waiting == 0) std::this_thread::yield();
  lease.reset();
  waiting.join();
  EXPECT_OK(waited);
}

TEST_F(PoolTest, ReplacesConnectionsThatTheServerHasClosed) {
  {
    ASSERT_OK_AND_ASSIGN(const Pool::Lease first, pool_->Acquire(Soon()));
    ASSERT_OK_AND_ASSIGN(const Pool::Lease second, pool_->Acquire(Soon()));
  }
  EXPECT_EQ(pool_->stats().open, 2);
  TerminateBackends();
  // No caller notices.
  EXPECT_OK(ExecuteAlone(*pool_, Soon(), kOne, Params()));
  EXPECT_OK(ExecuteAlone(*pool_, Soon(), kOne, Params()));
  EXPECT_EQ(pool_->stats().open, 1);
}

TEST_F(PoolTest, AsksIdleConnectionsBeforeGivingThemOut) {
  const auto pool = Make({.url = database_.url(), .check_idle_after = std::chrono::milliseconds(0)});
  for (int i = 0; i < 3; ++i) EXPECT_OK(ExecuteAlone(*pool, Soon(), kOne, Params()));
  EXPECT_EQ(pool->stats().opened, 1);
}

TEST_F(PoolTest, DoesNotGiveOutAConnectionWithAnOpenTransaction) {
  constexpr Statement kBegin{"beginning", "BEGIN"};
  {
    ASSERT_OK_AND_ASSIGN(const Pool::Lease lease, pool_->Acquire(Soon()));
    lease->Queue(kBegin, Params());
    ASSERT_OK(lease->Flush(Soon()));
  }
  EXPECT_EQ(pool_->stats().open, 0);
  {
    ASSERT_OK_AND_ASSIGN(const Pool::Lease lease, pool_->Acquire(Soon()));
    lease->Queue(kOne, Params());  // never flushed
  }
  EXPECT_EQ(pool_->stats().open, 0);
}

TEST_F(PoolTest, AnUnreachableServerIsUnavailableAtOnceWhileItBacksOff) {
  const auto pool = Make({.url = "postgresql:///enfilade?host=/nonexistent",
                          .first_backoff = std::chrono::seconds(60),
                          .max_backoff = std::chrono::seconds(60)});
  const absl::Status first = Ping(*pool);
  EXPECT_STATUS(first, absl::StatusCode::kUnavailable, Not(HasSubstr("/nonexistent")));
  EXPECT_THAT(DatabaseTextOf(first), HasSubstr("/nonexistent"));
  EXPECT_EQ(Ping(*pool), first);
  EXPECT_EQ(pool->stats().failures, 1);
  EXPECT_EQ(pool->stats().open, 0);
}

TEST_F(PoolTest, AMissingDatabaseOrRoleIsUnavailableAndNotNamed) {
  std::string url = database_.url();
  url.replace(url.find("/enfilade_test_"), 15, "/no_such_thing_");
  EXPECT_STATUS(Ping(*Make({.url = url})), absl::StatusCode::kUnavailable, Not(HasSubstr("no_such_thing")));
  url = database_.url() + (database_.url().find('?') == std::string::npos ? "?" : "&") + "user=nobody_known";
  EXPECT_STATUS(Ping(*Make({.url = url})), absl::StatusCode::kUnavailable, Not(HasSubstr("nobody_known")));
}

TEST_F(PoolTest, ConnectsAgainWhenAKilledServerIsBack) {
  if (std::getenv("ENFILADE_TEST_DATABASE")) GTEST_SKIP() << "the server is not this test's own";
  const auto pool = Make({.url = database_.url(), .max_backoff = std::chrono::milliseconds(50)});
  ASSERT_OK(Ping(*pool));
  auto& cluster = enfilade::testing::Cluster::Instance();
  ASSERT_EQ(kill(cluster.pid(), SIGKILL), 0);
  // The killed server's connections end when their processes notice.
  absl::Status status;
  for (int i = 0; i < 500 && status.ok(); ++i) {
    status = Ping(*pool);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_CODE(status, absl::StatusCode::kUnavailable);
  cluster.Restart();
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  EXPECT_OK(Ping(*pool));
}

}  // namespace
}  // namespace enfilade::storage::postgres
