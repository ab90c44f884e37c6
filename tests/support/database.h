// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "storage/call_context.h"
#include "storage/postgres/driver/pool.h"

namespace enfilade::testing {

// A new database with all migrations, dropped with the guard. It is in a private cluster that starts with the first
// guard of a test program and ends with the program, however that ends; or, where the environment variable
// ENFILADE_TEST_DATABASE names a server (postgresql://user@host/database), in that server.
class TestDatabase {
 public:
  enum class Content { kMigrated, kEmpty };
  explicit TestDatabase(Content content = Content::kMigrated);
  ~TestDatabase();
  TestDatabase(const TestDatabase&) = delete;
  TestDatabase& operator=(const TestDatabase&) = delete;

  const std::string& url() const { return url_; }

  // Executes SQL and gives the first column of its rows, as text. A failure fails the test.
  std::vector<std::string> Sql(const std::string& sql) const;
  // The first of them; empty where there is none.
  std::string SqlValue(const std::string& sql) const;

 private:
  std::string name_;
  std::string url_;
};

// A test with a database of its own and a pool on it.
class DatabaseTest : public ::testing::Test {
 protected:
  DatabaseTest();

  // Time enough for any one call.
  static storage::CallContext Soon() { return storage::CallContext::WithTimeout(std::chrono::seconds(60)); }

  TestDatabase database_;
  std::unique_ptr<storage::postgres::Pool> pool_;
};

}  // namespace enfilade::testing
