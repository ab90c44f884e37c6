// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/spool/spool_schema.h"

#include <zlib.h>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::client {
namespace {

constexpr std::int64_t kApplicationId = 0x456E6653;  // "EnfS"

// entry: an encoded sensor::SessionEntry. surroundings: an Environment, 0 if unknown. kind: a sensor::RecordKind.
// payload: by sensor::EncodePayload. crc: CRC-32 of the payload, as SQLite has no checksums.
constexpr const char* kSchema = R"sql(
CREATE TABLE sessions (
  key INTEGER PRIMARY KEY,
  id TEXT NOT NULL UNIQUE,
  site TEXT NOT NULL,
  robot TEXT NOT NULL,
  map TEXT NOT NULL,
  request_id TEXT NOT NULL,
  source TEXT NOT NULL,
  entry BLOB NOT NULL DEFAULT x'',
  surroundings INTEGER NOT NULL DEFAULT 0,
  last_sequence INTEGER NOT NULL DEFAULT 0,
  acknowledged_sequence INTEGER NOT NULL DEFAULT 0,
  finished INTEGER NOT NULL DEFAULT 0,
  closed INTEGER NOT NULL DEFAULT 0);
CREATE TABLE records (
  session INTEGER NOT NULL REFERENCES sessions (key),
  sequence INTEGER NOT NULL,
  kind INTEGER NOT NULL,
  payload BLOB NOT NULL,
  crc INTEGER NOT NULL,
  blob BLOB,
  UNIQUE (session, sequence));
CREATE INDEX records_blob ON records (blob) WHERE blob IS NOT NULL;
CREATE TABLE quarantine (
  session INTEGER NOT NULL REFERENCES sessions (key),
  sequence INTEGER NOT NULL,
  kind INTEGER NOT NULL,
  payload BLOB NOT NULL,
  blob BLOB,
  reason TEXT NOT NULL,
  UNIQUE (session, sequence));
CREATE TABLE blobs (
  sha256 BLOB PRIMARY KEY,
  content BLOB NOT NULL);
)sql";

absl::Status Create(SqliteDatabase& database) {
  ENFILADE_RETURN_IF_ERROR(database.Execute("PRAGMA auto_vacuum = INCREMENTAL"));
  ENFILADE_ASSIGN_OR_RETURN(SqliteTransaction transaction, SqliteTransaction::Begin(database));
  ENFILADE_RETURN_IF_ERROR(database.Execute(kSchema));
  ENFILADE_RETURN_IF_ERROR(database.Execute(
      fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplicationId, kSpoolVersion)));
  return transaction.Commit();
}

// Sessions of layout 1 have no entry, those of layouts 1 and 2 no environment.
absl::Status Upgrade(SqliteDatabase& database, std::int64_t version) {
  ENFILADE_ASSIGN_OR_RETURN(SqliteTransaction transaction, SqliteTransaction::Begin(database));
  if (version < 2) {
    ENFILADE_RETURN_IF_ERROR(database.Execute("ALTER TABLE sessions ADD COLUMN entry BLOB NOT NULL DEFAULT x''"));
  }
  ENFILADE_RETURN_IF_ERROR(database.Execute("ALTER TABLE sessions ADD COLUMN surroundings INTEGER NOT NULL DEFAULT 0"));
  ENFILADE_RETURN_IF_ERROR(database.Execute(fmt::format("PRAGMA user_version = {}", kSpoolVersion)));
  return transaction.Commit();
}

}  // namespace

std::int64_t Crc(std::string_view bytes) {
  return static_cast<std::int64_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

absl::Status PrepareSpoolFile(SqliteDatabase& database, const std::string& path, bool check) {
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t tables, database.QueryInt("SELECT count(*) FROM sqlite_master"));
  if (tables == 0) ENFILADE_RETURN_IF_ERROR(Create(database));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t application, database.QueryInt("PRAGMA application_id"));
  if (application != kApplicationId) return FailedPrecondition("{}: another program's file, not a spool", path);
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version, database.QueryInt("PRAGMA user_version"));
  if (version > kSpoolVersion) {
    return FailedPrecondition(
        "{}: written by a newer program (layout {}; this program knows up to {}): update this program", path, version,
        kSpoolVersion);
  }
  if (version < kSpoolVersion) ENFILADE_RETURN_IF_ERROR(Upgrade(database, version));
  if (!check) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const std::string report, database.QueryText("PRAGMA quick_check(1)"));
  if (report == "ok") return absl::OkStatus();
  return DataLoss("{}: the file is damaged ({}); move it away to start a new one", path, report);
}

absl::Status ConfigureConnection(SqliteDatabase& database) {
  return database.Execute(
      "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON;"
      "PRAGMA journal_size_limit = 16777216");
}

}  // namespace enfilade::client
