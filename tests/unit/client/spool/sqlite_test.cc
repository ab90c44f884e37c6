// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/spool/sqlite.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "client/sdk/spool/file_lock.h"
#include "io/file.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::client {
namespace {

using ::testing::HasSubstr;

class SqliteTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto database = SqliteDatabase::Open(path_);
    ASSERT_OK(database);
    database_.emplace(*std::move(database));
    ASSERT_OK(database_->Execute("CREATE TABLE t (id INTEGER PRIMARY KEY, v UNIQUE)"));
  }
  std::int64_t Rows() { return *database_->QueryInt("SELECT count(*) FROM t"); }

  testing::TemporaryDirectory directory_;
  const std::string path_ = (directory_.path() / "t.db").string();
  std::optional<SqliteDatabase> database_;
};

TEST_F(SqliteTest, ValuesComeBackAsTheyWereBound) {
  ASSERT_OK_AND_ASSIGN(SqliteStatement insert, database_->Prepare("INSERT INTO t (id, v) VALUES (?, ?)"));
  const std::string bytes("a\0b\xff", 4);
  ASSERT_OK(insert.Bind(1, 1).BindBlob(2, bytes).Run());
  ASSERT_OK(insert.Bind(1, 2).BindText(2, "text").Run());
  ASSERT_OK(insert.Bind(1, 3).BindNull(2).Run());
  ASSERT_OK(insert.Bind(1, 4).Bind(2, std::int64_t{1} << 62).Run());
  ASSERT_OK(insert.Bind(1, 5).BindBlob(2, "").Run());
  ASSERT_OK_AND_ASSIGN(SqliteStatement query, database_->Prepare("SELECT v FROM t ORDER BY id"));
  ASSERT_TRUE(*query.Step());
  EXPECT_EQ(query.Blob(0), bytes);
  EXPECT_EQ(query.Number(0), std::nullopt);
  ASSERT_TRUE(*query.Step());
  EXPECT_EQ(query.Text(0), "text");
  ASSERT_TRUE(*query.Step());
  EXPECT_TRUE(query.IsNull(0));
  EXPECT_EQ(query.Blob(0), "");
  ASSERT_TRUE(*query.Step());
  EXPECT_EQ(query.Int(0), std::int64_t{1} << 62);
  EXPECT_EQ(query.Number(0), 0x1p62);
  ASSERT_TRUE(*query.Step());
  EXPECT_FALSE(query.IsNull(0)) << "an empty blob is not NULL";
  EXPECT_FALSE(*query.Step());
}

TEST_F(SqliteTest, BindingsDoNotOutliveARun) {
  ASSERT_OK_AND_ASSIGN(SqliteStatement insert, database_->Prepare("INSERT INTO t (id, v) VALUES (?, ?)"));
  ASSERT_OK(insert.Bind(1, 1).BindText(2, "first").Run());
  ASSERT_OK(insert.Bind(1, 2).Run());
  EXPECT_EQ(*database_->QueryText("SELECT coalesce(v, 'none') FROM t WHERE id = 2"), "none");
}

TEST_F(SqliteTest, QueriesWithoutRowsGiveZeroAndNothing) {
  EXPECT_EQ(*database_->QueryInt("SELECT id FROM t"), 0);
  EXPECT_EQ(*database_->QueryText("SELECT v FROM t"), "");
}

TEST_F(SqliteTest, ATransactionThatIsNotCommittedLeavesNothing) {
  {
    ASSERT_OK_AND_ASSIGN(SqliteTransaction transaction, SqliteTransaction::Begin(*database_));
    ASSERT_OK(database_->Execute("INSERT INTO t (id) VALUES (1), (2)"));
    EXPECT_EQ(database_->Changes(), 2);
    EXPECT_FALSE(SqliteTransaction::Begin(*database_).ok()) << "one at a time";
  }
  EXPECT_EQ(Rows(), 0);
  {
    ASSERT_OK_AND_ASSIGN(SqliteTransaction transaction, SqliteTransaction::Begin(*database_));
    ASSERT_OK(database_->Execute("INSERT INTO t (id) VALUES (1)"));
    SqliteTransaction moved = std::move(transaction);
    ASSERT_OK(moved.Commit());
  }
  EXPECT_EQ(Rows(), 1);
}

TEST_F(SqliteTest, ErrorsNameTheFileAndLeaveTheStatementUsable) {
  EXPECT_STATUS(database_->Execute("SELEC 1"), absl::StatusCode::kInternal, HasSubstr(path_ + ": "));
  EXPECT_STATUS(database_->Prepare("SELECT x FROM t"), absl::StatusCode::kInternal, HasSubstr("no such column"));
  ASSERT_OK_AND_ASSIGN(SqliteStatement insert, database_->Prepare("INSERT INTO t (id) VALUES (?)"));
  ASSERT_OK(insert.Bind(1, 1).Run());
  EXPECT_FALSE(insert.Bind(1, 1).Run().ok()) << "the same key again";
  EXPECT_OK(insert.Bind(1, 2).Run());
  EXPECT_EQ(Rows(), 2);
}

TEST_F(SqliteTest, AReadOnlyConnectionChangesNothing) {
  ASSERT_OK_AND_ASSIGN(SqliteDatabase reader, SqliteDatabase::OpenToRead(path_));
  EXPECT_CODE(reader.Execute("INSERT INTO t (id) VALUES (1)"), absl::StatusCode::kPermissionDenied);
  EXPECT_EQ(*reader.QueryInt("SELECT count(*) FROM t"), 0);
}

TEST_F(SqliteTest, WhatCannotBeOpenedHasACodeOfItsOwn) {
  const std::string absent = (directory_.path() / "absent.db").string();
  EXPECT_STATUS(SqliteDatabase::OpenToRead(absent), absl::StatusCode::kNotFound, HasSubstr("absent.db"));
  EXPECT_FALSE(std::filesystem::exists(absent));
  EXPECT_CODE(SqliteDatabase::Open((directory_.path() / "none" / "a.db").string()), absl::StatusCode::kNotFound);
  const std::string text = (directory_.path() / "text").string();
  ASSERT_OK(io::WriteFile(text, std::string(5000, 'x')));
  ASSERT_OK_AND_ASSIGN(SqliteDatabase other, SqliteDatabase::Open(text));  // SQLite looks at the first use
  EXPECT_CODE(other.QueryInt("SELECT count(*) FROM sqlite_master"), absl::StatusCode::kDataLoss);
}

TEST_F(SqliteTest, APageLimitIsAFullDisk) {
  ASSERT_OK(database_->QueryInt("PRAGMA max_page_count = 8"));
  ASSERT_OK_AND_ASSIGN(SqliteStatement insert, database_->Prepare("INSERT INTO t (v) VALUES (randomblob(?))"));
  absl::Status status;
  for (int i = 0; i < 20 && status.ok(); ++i) status = insert.Bind(1, 3000).Run();
  EXPECT_STATUS(status, absl::StatusCode::kResourceExhausted, HasSubstr("disk space"));
  EXPECT_GT(Rows(), 0);
}

TEST(FileLockTest, IsHeldByOneUntilItGoes) {
  const testing::TemporaryDirectory directory;
  const std::string file = (directory.path() / "a.spool").string();
  {
    ASSERT_OK_AND_ASSIGN(const FileLock lock, FileLock::Take(file));
    EXPECT_STATUS(FileLock::Take(file), absl::StatusCode::kFailedPrecondition,
                  HasSubstr("process " + std::to_string(getpid())));
    EXPECT_OK(FileLock::Take(file + "2"));
  }
  EXPECT_OK(FileLock::Take(file));
  EXPECT_CODE(FileLock::Take((directory.path() / "none" / "a").string()), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::client
