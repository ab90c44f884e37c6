// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

struct sqlite3;
struct sqlite3_stmt;

namespace enfilade::client {

// A prepared statement. Views of columns hold until the next Step or Reset. Not thread-safe.
class SqliteStatement {
 public:
  SqliteStatement(sqlite3* database, sqlite3_stmt* statement) : database_(database), statement_(statement) {}

  // Parameters count from 1. Bytes must live until the statement is reset. Chainable.
  SqliteStatement& Bind(int index, std::int64_t value);
  SqliteStatement& BindText(int index, std::string_view text);
  SqliteStatement& BindBlob(int index, std::string_view bytes);
  SqliteStatement& BindNull(int index);

  // True while there is a row.
  absl::StatusOr<bool> Step();
  // Runs a statement without result rows, then resets it.
  absl::Status Run();
  void Reset();

  std::int64_t Int(int column) const;
  // Unset if the value is not a number.
  std::optional<double> Number(int column) const;
  std::string_view Text(int column) const;
  std::string_view Blob(int column) const;
  bool IsNull(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };

  sqlite3* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

// One connection to an SQLite file. Errors: RESOURCE_EXHAUSTED: disk full; DATA_LOSS: damaged, or not an SQLite file;
// PERMISSION_DENIED; NOT_FOUND: no such folder; otherwise INTERNAL. Messages begin with the path. Not thread-safe.
class SqliteDatabase {
 public:
  static absl::StatusOr<SqliteDatabase> Open(const std::string& path);
  // NOT_FOUND: no such file.
  static absl::StatusOr<SqliteDatabase> OpenToRead(const std::string& path);

  // One or several statements without parameters and rows.
  absl::Status Execute(const std::string& sql);
  absl::StatusOr<SqliteStatement> Prepare(const std::string& sql);
  // The first column of the first row; 0 if there are no rows.
  absl::StatusOr<std::int64_t> QueryInt(const std::string& sql);
  absl::StatusOr<std::string> QueryText(const std::string& sql);
  // Rows that the last INSERT, UPDATE or DELETE changed.
  std::int64_t Changes() const;

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };

  static absl::StatusOr<SqliteDatabase> OpenWith(const std::string& path, int flags);
  explicit SqliteDatabase(sqlite3* database) : database_(database) {}

  std::unique_ptr<sqlite3, Close> database_;
};

// A write transaction: rolled back unless committed.
class SqliteTransaction {
 public:
  static absl::StatusOr<SqliteTransaction> Begin(SqliteDatabase& database);
  ~SqliteTransaction();
  SqliteTransaction(SqliteTransaction&& other) noexcept : database_(other.database_) { other.database_ = nullptr; }
  SqliteTransaction& operator=(SqliteTransaction&&) = delete;

  absl::Status Commit();

 private:
  explicit SqliteTransaction(SqliteDatabase& database) : database_(&database) {}

  SqliteDatabase* database_;
};

}  // namespace enfilade::client
