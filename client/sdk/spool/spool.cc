// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/spool/spool.h"

#include <algorithm>
#include <utility>

#include "client/sdk/spool/spool_schema.h"
#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/sensor/record_codec.h"

namespace enfilade::client {
namespace {

// Records are dropped in transactions of this size, so that appending never waits long.
constexpr std::int64_t kTrimSlice = 2000;

// What is left of a record that can no longer be read.
sensor::Record Damaged(std::int64_t sequence, const std::string& why) {
  return {sequence, sensor::Withheld{"the record was damaged on the robot's disk: " + why}};
}

absl::StatusOr<std::vector<SpoolSession>> ReadSessions(SqliteDatabase& database, std::vector<std::int64_t>& keys) {
  ENFILADE_ASSIGN_OR_RETURN(SqliteStatement query,
                            database.Prepare("SELECT key, id, site, robot, map, request_id, source, "
                                             "last_sequence, acknowledged_sequence, finished, "
                                             "closed, entry, surroundings FROM sessions ORDER BY key"));
  std::vector<SpoolSession> sessions;
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(const bool found, query.Step());
    if (!found) return sessions;
    keys.push_back(query.Int(0));
    SpoolSession& session = sessions.emplace_back();
    session.id = SessionId(std::string(query.Text(1)));
    session.site = SiteId(std::string(query.Text(2)));
    session.robot = RobotId(std::string(query.Text(3)));
    session.map = query.Text(4);
    session.request_id = query.Text(5);
    session.source = query.Text(6);
    session.last_sequence = query.Int(7);
    session.acknowledged_sequence = query.Int(8);
    session.finished = query.Int(9) != 0;
    session.closed = query.Int(10) != 0;
    ENFILADE_ASSIGN_OR_RETURN(session.entry, sensor::DecodeSessionEntry(query.Blob(11)));
    if (const std::int64_t environment = query.Int(12); environment != 0) {
      session.environment = static_cast<Environment>(environment);
    }
  }
}

}  // namespace

TimeNs TimeOf(const SpoolItem& item) { return enfilade::sensor::TimeOf(item.payload); }

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

absl::Status Spool::Load() {
  std::vector<std::int64_t> keys;
  ENFILADE_ASSIGN_OR_RETURN(std::vector<SpoolSession> sessions, ReadSessions(writer_, keys));
  usage_.max_bytes = options_.max_bytes;
  ENFILADE_ASSIGN_OR_RETURN(usage_.records, writer_.QueryInt("SELECT count(*) FROM records"));
  ENFILADE_ASSIGN_OR_RETURN(usage_.quarantined, writer_.QueryInt("SELECT count(*) FROM quarantine"));
  for (const char* table : {"records", "quarantine"}) {
    ENFILADE_ASSIGN_OR_RETURN(const std::int64_t bytes,
                              writer_.QueryInt(fmt::format("SELECT sum(length(payload)) FROM {}", table)));
    usage_.bytes += bytes;
  }
  usage_.bytes += (usage_.records + usage_.quarantined) * kRecordOverhead;
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t blob_bytes, writer_.QueryInt("SELECT sum(length(content)) FROM blobs"));
  usage_.bytes += blob_bytes;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const std::string id = sessions[i].id.value();
    SessionRow& row = sessions_[id];
    row = {keys[i], std::move(sessions[i])};
    // The process may have ended between the acknowledgement and the trimming.
    ENFILADE_RETURN_IF_ERROR(Trim(row));
  }
  Publish();
  return absl::OkStatus();
}

absl::StatusOr<Spool::SessionRow*> Spool::RowOf(const SessionId& id) {
  const auto row = sessions_.find(id.value());
  if (row == sessions_.end()) return NotFound("{}: the spool holds no session {}", path_, id.value());
  return &row->second;
}

absl::Status Spool::CreateSession(const SpoolSession& session) {
  MutexLock writing(writer_mutex_);
  if (sessions_.contains(session.id.value())) {
    return AlreadyExists("{}: the spool holds a session {} already", path_, session.id.value());
  }
  ENFILADE_ASSIGN_OR_RETURN(SqliteStatement insert,
                            writer_.Prepare("INSERT INTO sessions (id, site, robot, map, request_id, source, "
                                            "entry, surroundings) VALUES (?, ?, ?, ?, ?, ?, ?, ?) RETURNING key"));
  const std::string entry = sensor::Encode(session.entry);
  insert.BindText(1, session.id.value()).BindText(2, session.site.value()).BindText(3, session.robot.value());
  insert.BindText(4, session.map).BindText(5, session.request_id).BindText(6, session.source);
  insert.BindBlob(7, entry).Bind(8, static_cast<std::int64_t>(session.environment.value_or(Environment{})));
  ENFILADE_RETURN_IF_ERROR(insert.Step().status());
  const std::int64_t key = insert.Int(0);
  ENFILADE_RETURN_IF_ERROR(insert.Step().status());  // to its end: this commits
  SpoolSession fresh = session;
  fresh.last_sequence = fresh.acknowledged_sequence = 0;
  fresh.finished = fresh.closed = false;
  sessions_[session.id.value()] = {key, std::move(fresh)};
  Publish();
  return absl::OkStatus();
}

std::optional<SpoolSession> Spool::FindSession(const SessionId& id) {
  MutexLock writing(writer_mutex_);
  const auto row = sessions_.find(id.value());
  if (row == sessions_.end()) return std::nullopt;
  return row->second.session;
}

std::vector<SpoolSession> Spool::ListSessions() {
  MutexLock writing(writer_mutex_);
  std::vector<const SessionRow*> rows;
  for (const auto& [id, row] : sessions_) rows.push_back(&row);
  std::sort(rows.begin(), rows.end(), [](const SessionRow* a, const SessionRow* b) { return a->key < b->key; });
  std::vector<SpoolSession> sessions;
  for (const SessionRow* row : rows) sessions.push_back(row->session);
  return sessions;
}

absl::Status Spool::RemoveSession(const SessionId& id) {
  MutexLock writing(writer_mutex_);
  ENFILADE_ASSIGN_OR_RETURN(const SessionRow* const row, RowOf(id));
  ENFILADE_ASSIGN_OR_RETURN(SqliteTransaction transaction, SqliteTransaction::Begin(writer_));
  for (const char* table : {"records", "quarantine"}) {
    ENFILADE_RETURN_IF_ERROR(writer_.Execute(fmt::format("DELETE FROM {} WHERE session = {}", table, row->key)));
  }
  ENFILADE_RETURN_IF_ERROR(writer_.Execute(fmt::format("DELETE FROM sessions WHERE key = {}", row->key)));
  ENFILADE_RETURN_IF_ERROR(
      writer_.Execute("DELETE FROM blobs WHERE NOT EXISTS (SELECT 1 FROM records WHERE blob = sha256) AND "
                      "NOT EXISTS (SELECT 1 FROM quarantine WHERE blob = sha256)"));
  ENFILADE_RETURN_IF_ERROR(transaction.Commit());
  sessions_.clear();
  const std::int64_t refused = usage_.refused;
  usage_ = {};
  usage_.refused = refused;
  return Load();
}

absl::Status Spool::MarkFinished(const SessionId& id) {
  MutexLock writing(writer_mutex_);
  ENFILADE_ASSIGN_OR_RETURN(SessionRow* const row, RowOf(id));
  ENFILADE_RETURN_IF_ERROR(writer_.Execute(fmt::format("UPDATE sessions SET finished = 1 WHERE key = {}", row->key)));
  row->session.finished = true;
  Publish();
  return absl::OkStatus();
}

absl::Status Spool::MarkClosed(const SessionId& id) {
  MutexLock writing(writer_mutex_);
  ENFILADE_ASSIGN_OR_RETURN(SessionRow* const row, RowOf(id));
  ENFILADE_RETURN_IF_ERROR(writer_.Execute(fmt::format("UPDATE sessions SET closed = 1 WHERE key = {}", row->key)));
  row->session.closed = true;
  return absl::OkStatus();
}

absl::StatusOr<std::vector<sensor::Record>> Spool::ReadBatch(const SessionId& id, std::int64_t after_sequence,
                                                             std::int64_t max_records, std::int64_t max_bytes) {
  std::int64_t key = 0;
  {
    MutexLock lock(mutex_);
    const auto session = published_.find(id.value());
    if (session == published_.end()) return NotFound("{}: the spool holds no session {}", path_, id.value());
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
            : DataLoss("its checksum does not fit");
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
  if (!found) return NotFound("{}: the spool holds no blob {}", path_, ToHex(blob.sha256));
  std::string content(query.Blob(0));
  if (Sha256(content) != blob.sha256) return DataLoss("{}: the blob {} is damaged", path_, ToHex(blob.sha256));
  return content;
}

absl::Status Spool::Acknowledge(const SessionId& id, std::int64_t sequence) {
  MutexLock writing(writer_mutex_);
  ENFILADE_ASSIGN_OR_RETURN(SessionRow* const row, RowOf(id));
  sequence = std::min(sequence, row->session.last_sequence);
  if (sequence <= row->session.acknowledged_sequence) return absl::OkStatus();
  // Not worth a flush: what is lost of it after a crash the server says again.
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
  // Gives a part of the freed pages back to the disk.
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
    return FailedPrecondition("{}: record {} of session {} is withheld already", path_, sequence, id.value());
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
