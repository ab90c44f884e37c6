// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/spool/spool.h"

#include <algorithm>
#include <utility>

#include "client/sdk/spool/spool_schema.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/sensor/record_codec.h"

namespace enfilade::client {
namespace {

// Records are deleted in transactions of this size, so that Append never waits long.
constexpr std::int64_t kTrimSlice = 2000;

// Takes the place of a record that can no longer be read.
sensor::Record Damaged(std::int64_t sequence, const std::string& why) {
  return {sequence, sensor::Withheld{"the record was damaged on the robot's disk: " + why}};
}

}  // namespace

TimeNs TimeOf(const SpoolItem& item) { return sensor::TimeOf(item.payload); }

Spool::Spool(std::string path, const SpoolOptions& options, FileLock lock, SqliteDatabase writer, SqliteDatabase reader)
    : path_(std::move(path)),
      options_(options),
      lock_(std::move(lock)),
      writer_(std::move(writer)),
      reader_(std::move(reader)) {}

absl::StatusOr<std::unique_ptr<Spool>> Spool::Open(const std::string& path, const SpoolOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(FileLock lock, FileLock::Take(path));
  ENFILADE_ASSIGN_OR_RETURN(SqliteDatabase writer, SqliteDatabase::Open(path));
  ENFILADE_RETURN_IF_ERROR(PrepareSpoolFile(writer, path, options.check_on_open));
  ENFILADE_RETURN_IF_ERROR(ConfigureConnection(writer));
  ENFILADE_ASSIGN_OR_RETURN(SqliteDatabase reader, SqliteDatabase::Open(path));
  ENFILADE_RETURN_IF_ERROR(ConfigureConnection(reader));
  std::unique_ptr<Spool> spool(new Spool(path, options, std::move(lock), std::move(writer), std::move(reader)));
  MutexLock writing(spool->writer_mutex_);
  ENFILADE_RETURN_IF_ERROR(spool->Load());
  return spool;
}

absl::StatusOr<std::vector<sensor::Record>> Spool::ReadBatch(const SessionId& id, std::int64_t after_sequence,
                                                             std::int64_t max_records, std::int64_t max_bytes) {
  std::int64_t key = 0;
  {
    MutexLock lock(mutex_);
    const auto session = published_.find(id.value());
    if (session == published_.end()) return NotFound("{}: the spool has no session {}", path_, id.value());
    key = session->second.key;
  }
  MutexLock reading(reader_mutex_);
  ENFILADE_ASSIGN_OR_RETURN(
      SqliteStatement query,
      reader_.Prepare("SELECT sequence, kind, payload, crc FROM records WHERE session = ? AND sequence > ? "
                      "ORDER BY sequence LIMIT ?"));
  query.Bind(1, key).Bind(2, after_sequence).Bind(3, max_records);
  std::vector<sensor::Record> records;
  std::int64_t bytes = 0;
  while (bytes < max_bytes) {
    ENFILADE_ASSIGN_OR_RETURN(const bool found, query.Step());
    if (!found) break;
    const std::int64_t sequence = query.Int(0);
    const std::string_view payload = query.Blob(2);
    const auto size = static_cast<std::int64_t>(payload.size());
    if (!records.empty() && bytes + size > max_bytes) break;
    absl::StatusOr<sensor::Record> record =
        Crc(payload) == query.Int(3)
            ? sensor::DecodePayload(sequence, static_cast<sensor::RecordKind>(query.Int(1)), payload)
            : DataLoss("its checksum differs");
    if (!record.ok()) record = Damaged(sequence, std::string(record.status().message()));
    bytes += size;
    if (const sensor::BlobRef* blob = sensor::FindBlob(*record)) bytes += blob->size;
    records.push_back(*std::move(record));
  }
  return records;
}

absl::StatusOr<std::string> Spool::ReadBlob(const sensor::BlobRef& blob) {
  MutexLock reading(reader_mutex_);
  ENFILADE_ASSIGN_OR_RETURN(SqliteStatement query, reader_.Prepare("SELECT content FROM blobs WHERE sha256 = ?"));
  query.BindBlob(1, blob.sha256);
  ENFILADE_ASSIGN_OR_RETURN(const bool found, query.Step());
  if (!found) return NotFound("{}: the spool has no blob {}", path_, ToHex(blob.sha256));
  std::string content(query.Blob(0));
  if (Sha256(content) != blob.sha256) return DataLoss("{}: the blob {} is damaged", path_, ToHex(blob.sha256));
  return content;
}

absl::Status Spool::Acknowledge(const SessionId& id, std::int64_t sequence) {
  MutexLock writing(writer_mutex_);
  ENFILADE_ASSIGN_OR_RETURN(SessionRow* const row, RowOf(id));
  sequence = std::min(sequence, row->session.last_sequence);
  if (sequence <= row->session.acknowledged_sequence) return absl::OkStatus();
  // Needs no flush: after a crash the server sends the acknowledged sequence again.
  ENFILADE_RETURN_IF_ERROR(writer_.Execute("PRAGMA synchronous = NORMAL"));
  absl::Status status =
      writer_.Execute(fmt::format("UPDATE sessions SET acknowledged_sequence = {} WHERE key = {}", sequence, row->key));
  if (status.ok()) row->session.acknowledged_sequence = sequence;
  if (status.ok()) status = Trim(*row);
  ENFILADE_RETURN_IF_ERROR(writer_.Execute("PRAGMA synchronous = FULL"));
  Publish();
  return status;
}

absl::Status Spool::Trim(SessionRow& row) {
  const std::int64_t acknowledged = row.session.acknowledged_sequence;
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(
        const std::int64_t oldest,
        writer_.QueryInt(fmt::format("SELECT min(sequence) FROM records WHERE session = {}", row.key)));
    if (oldest == 0 || oldest > acknowledged) break;
    const std::string slice = fmt::format("FROM records WHERE session = {} AND sequence <= {}", row.key,
                                          std::min(acknowledged, oldest + kTrimSlice - 1));
    ENFILADE_ASSIGN_OR_RETURN(SqliteTransaction transaction, SqliteTransaction::Begin(writer_));
    ENFILADE_ASSIGN_OR_RETURN(const std::int64_t payload_bytes,
                              writer_.QueryInt("SELECT sum(length(payload)) " + slice));
    ENFILADE_ASSIGN_OR_RETURN(const std::int64_t with_blobs, writer_.QueryInt("SELECT count(blob) " + slice));
    ENFILADE_RETURN_IF_ERROR(writer_.Execute("DELETE " + slice));
    const std::int64_t records = writer_.Changes();
    std::int64_t blob_bytes = 0;
    if (with_blobs > 0) {
      constexpr const char* kOrphans =
          "FROM blobs WHERE NOT EXISTS (SELECT 1 FROM records WHERE blob = sha256) AND "
          "NOT EXISTS (SELECT 1 FROM quarantine WHERE blob = sha256)";
      ENFILADE_ASSIGN_OR_RETURN(blob_bytes, writer_.QueryInt(fmt::format("SELECT sum(length(content)) {}", kOrphans)));
      ENFILADE_RETURN_IF_ERROR(writer_.Execute(fmt::format("DELETE {}", kOrphans)));
    }
    ENFILADE_RETURN_IF_ERROR(transaction.Commit());
    usage_.records -= records;
    usage_.bytes -= payload_bytes + records * kRecordOverhead + blob_bytes;
  }
  // Returns a part of the free pages to the file system.
  constexpr std::int64_t kIdlePages = 8192;
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t idle, writer_.QueryInt("PRAGMA freelist_count"));
  return idle > kIdlePages ? writer_.Execute("PRAGMA incremental_vacuum(1024)") : absl::OkStatus();
}

absl::Status Spool::Quarantine(const SessionId& id, std::int64_t sequence, const std::string& reason) {
  MutexLock writing(writer_mutex_);
  ENFILADE_ASSIGN_OR_RETURN(const SessionRow* const row, RowOf(id));
  ENFILADE_ASSIGN_OR_RETURN(SqliteTransaction transaction, SqliteTransaction::Begin(writer_));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t kind,
                            writer_.QueryInt(fmt::format(
                                "SELECT kind FROM records WHERE session = {} AND sequence = {}", row->key, sequence)));
  if (kind == 0) return NotFound("{}: record {} of session {} is not pending", path_, sequence, id.value());
  if (kind == static_cast<std::int64_t>(sensor::RecordKind::kWithheld)) {
    return FailedPrecondition("{}: record {} of session {} is already withheld", path_, sequence, id.value());
  }
  ENFILADE_ASSIGN_OR_RETURN(
      SqliteStatement keep,
      writer_.Prepare(
          "INSERT OR REPLACE INTO quarantine (session, sequence, kind, payload, blob, reason) "
          "SELECT session, sequence, kind, payload, blob, ? FROM records WHERE session = ? AND sequence = ?"));
  ENFILADE_RETURN_IF_ERROR(keep.BindText(1, reason).Bind(2, row->key).Bind(3, sequence).Run());
  constexpr std::size_t kMaxReason = 4000;  // the server takes 4096 bytes
  const std::string payload = sensor::EncodePayload({sequence, sensor::Withheld{reason.substr(0, kMaxReason)}});
  ENFILADE_ASSIGN_OR_RETURN(
      SqliteStatement replace,
      writer_.Prepare(
          "UPDATE records SET kind = ?, payload = ?, crc = ?, blob = NULL WHERE session = ? AND sequence = ?"));
  replace.Bind(1, static_cast<std::int64_t>(sensor::RecordKind::kWithheld)).BindBlob(2, payload).Bind(3, Crc(payload));
  ENFILADE_RETURN_IF_ERROR(replace.Bind(4, row->key).Bind(5, sequence).Run());
  ENFILADE_RETURN_IF_ERROR(transaction.Commit());
  ++usage_.quarantined;
  usage_.bytes += static_cast<std::int64_t>(payload.size()) + kRecordOverhead;
  Publish();
  return absl::OkStatus();
}

absl::StatusOr<std::vector<QuarantinedRecord>> Spool::ListQuarantined(const SessionId& id) {
  MutexLock writing(writer_mutex_);
  ENFILADE_ASSIGN_OR_RETURN(const SessionRow* const row, RowOf(id));
  ENFILADE_ASSIGN_OR_RETURN(
      SqliteStatement query,
      writer_.Prepare("SELECT sequence, kind, payload, reason FROM quarantine WHERE session = ? ORDER BY sequence"));
  query.Bind(1, row->key);
  std::vector<QuarantinedRecord> result;
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(const bool found, query.Step());
    if (!found) return result;
    absl::StatusOr<sensor::Record> record =
        sensor::DecodePayload(query.Int(0), static_cast<sensor::RecordKind>(query.Int(1)), query.Blob(2));
    if (!record.ok()) record = Damaged(query.Int(0), std::string(record.status().message()));
    result.push_back({*std::move(record), std::string(query.Text(3))});
  }
}

SpoolUsage Spool::usage() {
  MutexLock writing(writer_mutex_);
  return usage_;
}

}  // namespace enfilade::client
