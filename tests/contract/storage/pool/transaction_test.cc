// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/transaction.h"

#include <csignal>
#include <cstdlib>
#include <limits>
#include <thread>

#include "storage/postgres/driver/copy_buffer.h"
#include "storage/postgres/driver/error.h"
#include "tests/support/database.h"
#include "tests/support/status_assertions.h"

namespace enfilade::storage::postgres {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr Statement kSleep{"sleeping", "SELECT pg_sleep($1)"};
constexpr Statement kSelectOne{"selecting one", "SELECT 1::bigint"};
constexpr Statement kBackend{"asking for the process", "SELECT pg_backend_pid()"};
constexpr Statement kInsert{"inserting", "INSERT INTO t (k) VALUES ($1)"};
constexpr Statement kLock{"locking", "SELECT k FROM t WHERE k = $1 FOR UPDATE"};
constexpr Statement kCopy{"copying", "COPY t (k) FROM STDIN (FORMAT binary)"};

class TransactionTest : public enfilade::testing::DatabaseTest {
 protected:
  TransactionTest() { database_.Sql("CREATE TABLE t (k bigint PRIMARY KEY, CHECK (k < 1000))"); }

  Transaction Begin(std::chrono::milliseconds time = std::chrono::seconds(60)) {
    auto transaction = Transaction::Begin(*pool_, CallContext::WithTimeout(time));
    EXPECT_OK(transaction);
    return *std::move(transaction);
  }
  pid_t BackendOf(Transaction& transaction) {
    const auto result = transaction.Execute(kBackend, Params());
    EXPECT_OK(result);
    return Row(*result, 0).Int32();
  }
  std::vector<std::string> Rows() { return database_.Sql("SELECT k FROM t ORDER BY k"); }
};

TEST_F(TransactionTest, BindsAndReadsEveryTypeExactly) {
  constexpr Statement kEcho{"echoing", "SELECT $1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11"};
  const std::string text = "quote ' \" \\ slash / \xe2\x82\xac";
  const std::string bytes("\0\1\377", 3);
  const TimeNs time = 1'790'000'000'123'456'000;
  const std::vector<double> numbers = {0.1, -0.0, std::numeric_limits<double>::infinity()};
  ASSERT_OK_AND_ASSIGN(
      const Result result,
      ExecuteAlone(*pool_, Soon(), kEcho,
                   Params(true, std::int16_t{-2}, std::int32_t{-3}, std::numeric_limits<std::int64_t>::min(), 1.0 / 3,
                          text, Bytes{bytes}, Timestamp{time}, numbers, std::optional<std::int64_t>(),
                          std::optional<std::string_view>(text))));
  Row row(result, 0);
  EXPECT_TRUE(row.Bool());
  EXPECT_EQ(row.Int16(), -2);
  EXPECT_EQ(row.Int32(), -3);
  EXPECT_EQ(row.Int64(), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(row.Double(), 1.0 / 3);
  EXPECT_EQ(row.Text(), text);
  EXPECT_EQ(row.Bytes(), bytes);
  EXPECT_EQ(row.Time(), time);
  EXPECT_EQ(row.Doubles(), numbers);
  EXPECT_EQ(row.OptionalInt64(), std::nullopt);
  EXPECT_EQ(row.OptionalText(), text);
  EXPECT_OK(row.status());
}

TEST_F(TransactionTest, BindsArrays) {
  constexpr Statement kUnnest{
      "unnesting", "SELECT * FROM unnest($1::smallint[], $2::integer[], $3::bigint[], $4::text[], $5::bytea[])"};
  const std::vector<std::string_view> texts = {"a", "", "{\"c\"}"};
  const std::vector<Bytes> bytes = {{"x"}, {std::string_view("\0", 1)}, {""}};
  ASSERT_OK_AND_ASSIGN(const Result result,
                       ExecuteAlone(*pool_, Soon(), kUnnest,
                                    Params(std::vector<std::int16_t>{1, 2, 3}, std::vector<std::int32_t>{4, 5, 6},
                                           std::vector<std::int64_t>{7, 8, 9}, texts, bytes)));
  ASSERT_EQ(result.rows(), 3);
  for (int i = 0; i < 3; ++i) {
    Row row(result, i);
    EXPECT_EQ(row.Int16(), 1 + i);
    EXPECT_EQ(row.Int32(), 4 + i);
    EXPECT_EQ(row.Int64(), 7 + i);
    EXPECT_EQ(row.Text(), texts[static_cast<std::size_t>(i)]);
    EXPECT_EQ(row.Bytes(), bytes[static_cast<std::size_t>(i)].value);
    EXPECT_OK(row.status());
  }
  ASSERT_OK_AND_ASSIGN(const Result none, ExecuteAlone(*pool_, Soon(), kUnnest,
                                                       Params(std::vector<std::int16_t>{}, std::vector<std::int32_t>{},
                                                              std::vector<std::int64_t>{},
                                                              std::vector<std::string_view>{}, std::vector<Bytes>{})));
  EXPECT_EQ(none.rows(), 0);
}

TEST_F(TransactionTest, SaysWhichColumnDoesNotFit) {
  ASSERT_OK_AND_ASSIGN(const Result result, ExecuteAlone(*pool_, Soon(), kSelectOne, Params()));
  Row wrong(result, 0);
  wrong.Text();
  EXPECT_STATUS(wrong.status(), absl::StatusCode::kInternal, HasSubstr("int8"));
  Row missing(result, 0);
  missing.Int64();
  missing.Int64();
  EXPECT_STATUS(missing.status(), absl::StatusCode::kInternal, HasSubstr("is missing"));
}

TEST_F(TransactionTest, CommitsAllOrRollsBackAll) {
  {
    Transaction transaction = Begin();
    transaction.Queue(kInsert, Params(std::int64_t{1}));
    ASSERT_OK(transaction.Execute(kInsert, Params(std::int64_t{2})));
  }
  EXPECT_THAT(Rows(), ElementsAre());
  {
    Transaction transaction = Begin();
    transaction.Queue(kInsert, Params(std::int64_t{1}));
    transaction.Queue(kInsert, Params(std::int64_t{2}));
    ASSERT_OK(transaction.Commit());
  }
  EXPECT_THAT(Rows(), ElementsAre("1", "2"));
  EXPECT_EQ(pool_->stats().opened, 1);
}

TEST_F(TransactionTest, GivesTheFirstErrorOfWhatWasQueuedAndCommitsNothing) {
  Transaction transaction = Begin();
  transaction.Queue(kInsert, Params(std::int64_t{1}));
  transaction.Queue(kInsert, Params(std::int64_t{1}));
  transaction.Queue(kInsert, Params(std::int64_t{2000}));
  EXPECT_STATUS(transaction.Commit(), absl::StatusCode::kAlreadyExists, HasSubstr("inserting"));
  EXPECT_CODE(transaction.Commit(), absl::StatusCode::kInternal);
  EXPECT_THAT(Rows(), ElementsAre());
}

TEST_F(TransactionTest, NamesTheConstraintThatRefused) {
  const auto refused = ExecuteAlone(*pool_, Soon(), kInsert, Params(std::int64_t{1000}));
  EXPECT_CODE(refused, absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ConstraintOf(refused.status()), "t_k_check");
  EXPECT_EQ(SqlStateOf(refused.status()), "23514");
  EXPECT_OK(ExecuteAlone(*pool_, Soon(), kInsert, Params(std::int64_t{999})));
}

TEST_F(TransactionTest, AMissingSchemaIsUnavailableWithoutTheDatabasesWords) {
  for (const Statement& missing :
       {Statement{"reading", "SELECT * FROM no_schema.no_table"},
        Statement{"reading", "SELECT no_column FROM pg_class"}, Statement{"reading", "SELECT no_function()"}}) {
    EXPECT_STATUS(ExecuteAlone(*pool_, Soon(), missing, Params()).status(), absl::StatusCode::kUnavailable,
                  Not(HasSubstr("no_")));
  }
}

TEST_F(TransactionTest, ServesOnAfterAnError) {
  constexpr Statement kBroken{"breaking", "SELECT FROM FROM"};
  EXPECT_CODE(ExecuteAlone(*pool_, Soon(), kBroken, Params()), absl::StatusCode::kInternal);
  EXPECT_CODE(ExecuteAlone(*pool_, Soon(), kBroken, Params()), absl::StatusCode::kInternal);
  EXPECT_OK(ExecuteAlone(*pool_, Soon(), kSelectOne, Params()));
  EXPECT_EQ(pool_->stats().opened, 1);
}

TEST_F(TransactionTest, RefusesTextsThatTheDatabaseCannotHold) {
  constexpr Statement kText{"echoing", "SELECT $1"};
  EXPECT_CODE(ExecuteAlone(*pool_, Soon(), kText, Params(std::string("a\0b", 3))), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(ExecuteAlone(*pool_, Soon(), kText, Params("\xff")), absl::StatusCode::kInvalidArgument);
}

TEST_F(TransactionTest, TheServerGivesUpAtTheDeadline) {
  const auto context = CallContext::WithTimeout(std::chrono::milliseconds(150));
  EXPECT_CODE(ExecuteAlone(*pool_, context, kSleep, Params(30.0)), absl::StatusCode::kDeadlineExceeded);
  // It was the server's own timeout: the connection is as good as before.
  EXPECT_OK(ExecuteAlone(*pool_, Soon(), kSelectOne, Params()));
  EXPECT_EQ(pool_->stats().opened, 1);
}

TEST_F(TransactionTest, TheTimeoutIsWhatRemainsOfEachCallsDeadline) {
  constexpr Statement kTimeout{"asking for the timeout",
                               "SELECT setting::bigint FROM pg_settings WHERE name = 'statement_timeout'"};
  const auto timeout_alone = [&](std::chrono::milliseconds deadline) {
    const auto result = ExecuteAlone(*pool_, CallContext::WithTimeout(deadline), kTimeout, Params());
    EXPECT_OK(result);
    return result.ok() ? Row(*result, 0).Int64() : -1;
  };
  const auto expect_about = [](std::int64_t timeout, std::int64_t deadline) {
    EXPECT_LE(timeout, deadline);
    EXPECT_GE(timeout, deadline * 8 / 10);
  };
  expect_about(timeout_alone(std::chrono::seconds(60)), 60'000);
  expect_about(timeout_alone(std::chrono::seconds(20)), 20'000);
  expect_about(timeout_alone(std::chrono::seconds(60)), 60'000);
  {
    Transaction transaction = Begin(std::chrono::milliseconds(20'000));
    ASSERT_OK_AND_ASSIGN(const Result inside, transaction.Execute(kTimeout, Params()));
    expect_about(Row(inside, 0).Int64(), 20'000);
  }
  // What that transaction set is rolled back with it; so is what a call that fails sets.
  expect_about(timeout_alone(std::chrono::seconds(20)), 20'000);
  constexpr Statement kText{"sending a text", "SELECT $1::text"};
  EXPECT_FALSE(ExecuteAlone(*pool_, CallContext::WithTimeout(std::chrono::seconds(40)), kText, Params("\xff")).ok());
  expect_about(timeout_alone(std::chrono::seconds(40)), 40'000);
  EXPECT_EQ(pool_->stats().opened, 1);
}

TEST_F(TransactionTest, WaitsNoLongerThanTheDeadlineForAServerThatHangs) {
  if (std::getenv("ENFILADE_TEST_DATABASE")) GTEST_SKIP() << "the server is not this test's own";
  Transaction transaction = Begin(std::chrono::milliseconds(500));
  const pid_t backend = BackendOf(transaction);
  ASSERT_EQ(kill(backend, SIGSTOP), 0);
  EXPECT_CODE(transaction.Execute(kSelectOne, Params()), absl::StatusCode::kDeadlineExceeded);
  kill(backend, SIGCONT);
}

TEST_F(TransactionTest, AKilledConnectionIsUnavailableAndReplaced) {
  {
    Transaction transaction = Begin();
    ASSERT_OK(transaction.Execute(kInsert, Params(std::int64_t{1})));
    database_.Sql("SELECT pg_terminate_backend(" + std::to_string(BackendOf(transaction)) + ", 5000)");
    EXPECT_CODE(transaction.Commit(), absl::StatusCode::kUnavailable);
  }
  EXPECT_EQ(pool_->stats().open, 0);
  EXPECT_OK(ExecuteAlone(*pool_, Soon(), kSelectOne, Params()));
  EXPECT_THAT(Rows(), ElementsAre());
}

TEST_F(TransactionTest, ADeadlockIsAborted) {
  database_.Sql("INSERT INTO t VALUES (1), (2)");
  Transaction first = Begin();
  Transaction second = Begin();
  ASSERT_OK(first.Execute(kLock, Params(std::int64_t{1})));
  ASSERT_OK(second.Execute(kLock, Params(std::int64_t{2})));
  absl::Status first_outcome;
  std::thread waiting([&] { first_outcome = first.Execute(kLock, Params(std::int64_t{2})).status(); });
  const absl::Status second_outcome = second.Execute(kLock, Params(std::int64_t{1})).status();
  if (absl::IsAborted(second_outcome)) {
    const Transaction rolled_back = std::move(second);
  }
  waiting.join();
  EXPECT_TRUE(absl::IsAborted(first_outcome) != absl::IsAborted(second_outcome))
      << first_outcome << " and " << second_outcome;
}

TEST_F(TransactionTest, CopiesRowsAndServesOnAfterACopyThatFails) {
  const auto copy = [&](std::int64_t first, std::int64_t last) {
    CopyBuffer rows;
    for (std::int64_t k = first; k <= last; ++k) {
      rows.BeginRow(1);
      rows.Put(k);
    }
    Transaction transaction = Begin();
    const absl::Status copied = transaction.CopyIn(kCopy, rows.Finish());
    return copied.ok() ? transaction.Commit() : copied;
  };
  EXPECT_OK(copy(1, 3));
  EXPECT_STATUS(copy(3, 5), absl::StatusCode::kAlreadyExists, HasSubstr("copying"));
  EXPECT_OK(copy(4, 4));
  EXPECT_THAT(Rows(), ElementsAre("1", "2", "3", "4"));
  EXPECT_EQ(pool_->stats().opened, 1);
}

TEST_F(TransactionTest, CopiesMoreThanTheSocketTakesAtOnce) {
  database_.Sql("CREATE TABLE large (v bytea)");
  constexpr Statement kCopyLarge{"copying", "COPY large (v) FROM STDIN (FORMAT binary)"};
  CopyBuffer rows;
  for (int i = 0; i < 20; ++i) {
    rows.BeginRow(1);
    rows.PutAppended([&](std::string& out) { out.append(1 << 20, static_cast<char>(i)); });
  }
  Transaction transaction = Begin();
  ASSERT_OK(transaction.CopyIn(kCopyLarge, rows.Finish()));
  ASSERT_OK(transaction.Commit());
  EXPECT_EQ(database_.SqlValue("SELECT sum(octet_length(v)) FROM large"), std::to_string(20 << 20));
}

}  // namespace
}  // namespace enfilade::storage::postgres
