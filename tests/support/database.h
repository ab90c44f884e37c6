// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "storage/call_context.h"
#include "storage/postgres/driver/pool.h"

namespace enfilade::testing {

// A new database with all migrations; the destructor drops it. It is in a private cluster that starts with the first
// TestDatabase of a test program and ends with the program, even if that is killed. If the environment variable
// ENFILADE_TEST_DATABASE names a server (postgresql://user@host/database), it is in that server instead.
class TestDatabase {
 public:
  enum class Content { kMigrated, kEmpty };
  explicit TestDatabase(Content content = Content::kMigrated);
  ~TestDatabase();
  TestDatabase(const TestDatabase&) = delete;
  TestDatabase& operator=(const TestDatabase&) = delete;

  const std::string& url() const { return url_; }

  // Executes SQL and returns the first column of its rows, as text. An error fails the test.
  std::vector<std::string> Sql(const std::string& sql) const;
  // The first of them; empty if there is none.
  std::string SqlValue(const std::string& sql) const;

 private:
  std::string name_;
  std::string url_;
};

// A test with its own database and a pool on it.
class DatabaseTest : public ::testing::Test {
 protected:
  DatabaseTest();

  // Enough time for any single call.
  static storage::CallContext Soon() { return storage::CallContext::WithTimeout(std::chrono::seconds(60)); }

  TestDatabase database_;
  std::unique_ptr<storage::postgres::Pool> pool_;
};

}  // namespace enfilade::testing
