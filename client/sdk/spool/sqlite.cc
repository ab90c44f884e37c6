// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/spool/sqlite.h"

#include <sqlite3.h>

#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::client {
namespace {

absl::StatusCode CodeOf(int result) {
  switch (result & 0xFF) {
    case SQLITE_FULL:
      return absl::StatusCode::kResourceExhausted;
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return absl::StatusCode::kDataLoss;
    case SQLITE_PERM:
    case SQLITE_READONLY:
      return absl::StatusCode::kPermissionDenied;
    case SQLITE_CANTOPEN:
      return absl::StatusCode::kNotFound;
    default:
      return absl::StatusCode::kInternal;
  }
}

absl::Status ErrorOf(sqlite3* database, int result) {
  const char* path = sqlite3_db_filename(database, "main");
  const char* hint = "";
  switch (CodeOf(result)) {
    case absl::StatusCode::kResourceExhausted:
      hint = ": free some disk space";
      break;
    case absl::StatusCode::kDataLoss:
      hint = ": the file is damaged or not a spool; move it away to start a new one";
      break;
    case absl::StatusCode::kNotFound:
      hint = ": does its folder exist?";
      break;
    default:
      break;
  }
  return absl::Status(CodeOf(result),
                      fmt::format("{}: {}{}", path && *path ? path : "spool", sqlite3_errmsg(database), hint));
}

std::string_view View(const void* data, int size) {
  return data ? std::string_view(static_cast<const char*>(data), static_cast<std::size_t>(size)) : std::string_view();
}

}  // namespace

void SqliteStatement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
void SqliteDatabase::Close::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

SqliteStatement& SqliteStatement::Bind(int index, std::int64_t value) {
  sqlite3_bind_int64(statement_.get(), index, value);
  return *this;
}

SqliteStatement& SqliteStatement::BindText(int index, std::string_view text) {
  sqlite3_bind_text64(statement_.get(), index, text.data(), text.size(), SQLITE_STATIC, SQLITE_UTF8);
  return *this;
}

SqliteStatement& SqliteStatement::BindBlob(int index, std::string_view bytes) {
  // A null pointer would bind NULL.
  sqlite3_bind_blob64(statement_.get(), index, bytes.empty() ? "" : bytes.data(), bytes.size(), SQLITE_STATIC);
  return *this;
}

SqliteStatement& SqliteStatement::BindNull(int index) {
  sqlite3_bind_null(statement_.get(), index);
  return *this;
}

absl::StatusOr<bool> SqliteStatement::Step() {
  const int result = sqlite3_step(statement_.get());
  if (result == SQLITE_ROW) return true;
  if (result == SQLITE_DONE) return false;
  absl::Status status = ErrorOf(database_, result);
  Reset();
  return status;
}

absl::Status SqliteStatement::Run() {
  absl::Status status = Step().status();
  Reset();
  return status;
}

void SqliteStatement::Reset() {
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
}

std::int64_t SqliteStatement::Int(int column) const { return sqlite3_column_int64(statement_.get(), column); }

std::optional<double> SqliteStatement::Number(int column) const {
  const int type = sqlite3_column_type(statement_.get(), column);
  if (type != SQLITE_INTEGER && type != SQLITE_FLOAT) return std::nullopt;
  return sqlite3_column_double(statement_.get(), column);
}

std::string_view SqliteStatement::Text(int column) const {
  const void* data = sqlite3_column_text(statement_.get(), column);
  return View(data, sqlite3_column_bytes(statement_.get(), column));
}

std::string_view SqliteStatement::Blob(int column) const {
  const void* data = sqlite3_column_blob(statement_.get(), column);
  return View(data, sqlite3_column_bytes(statement_.get(), column));
}

bool SqliteStatement::IsNull(int column) const { return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL; }

absl::StatusOr<SqliteDatabase> SqliteDatabase::Open(const std::string& path) {
  return OpenWith(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
}

absl::StatusOr<SqliteDatabase> SqliteDatabase::OpenToRead(const std::string& path) {
  return OpenWith(path, SQLITE_OPEN_READONLY);
}

absl::StatusOr<SqliteDatabase> SqliteDatabase::OpenWith(const std::string& path, int flags) {
  sqlite3* raw = nullptr;
  const int result = sqlite3_open_v2(path.c_str(), &raw, flags | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE, nullptr);
  SqliteDatabase database(raw);
  if (!raw) return absl::ResourceExhaustedError(path + ": out of memory");
  if (result != SQLITE_OK) return WithContext(ErrorOf(raw, result), path);
  sqlite3_busy_timeout(raw, 10'000);
  return database;
}

absl::Status SqliteDatabase::Execute(const std::string& sql) {
  const int result = sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  return result == SQLITE_OK ? absl::OkStatus() : ErrorOf(database_.get(), result);
}

absl::StatusOr<SqliteStatement> SqliteDatabase::Prepare(const std::string& sql) {
  sqlite3_stmt* statement = nullptr;
  const int result =
      sqlite3_prepare_v2(database_.get(), sql.c_str(), static_cast<int>(sql.size()), &statement, nullptr);
  if (result != SQLITE_OK) return ErrorOf(database_.get(), result);
  return SqliteStatement(database_.get(), statement);
}

absl::StatusOr<std::int64_t> SqliteDatabase::QueryInt(const std::string& sql) {
  ENFILADE_ASSIGN_OR_RETURN(SqliteStatement query, Prepare(sql));
  ENFILADE_ASSIGN_OR_RETURN(const bool found, query.Step());
  return found ? query.Int(0) : 0;
}

absl::StatusOr<std::string> SqliteDatabase::QueryText(const std::string& sql) {
  ENFILADE_ASSIGN_OR_RETURN(SqliteStatement query, Prepare(sql));
  ENFILADE_ASSIGN_OR_RETURN(const bool found, query.Step());
  return found ? std::string(query.Text(0)) : std::string();
}

std::int64_t SqliteDatabase::Changes() const { return sqlite3_changes64(database_.get()); }

absl::StatusOr<SqliteTransaction> SqliteTransaction::Begin(SqliteDatabase& database) {
  ENFILADE_RETURN_IF_ERROR(database.Execute("BEGIN IMMEDIATE"));
  return SqliteTransaction(database);
}

SqliteTransaction::~SqliteTransaction() {
  // If SQLite has already rolled back (disk full), this fails, which is harmless.
  if (database_) database_->Execute("ROLLBACK").IgnoreError();
}

absl::Status SqliteTransaction::Commit() {
  absl::Status status = database_->Execute("COMMIT");
  if (status.ok()) database_ = nullptr;
  return status;
}

}  // namespace enfilade::client
