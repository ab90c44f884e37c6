// SPDX-License-Identifier: Apache-2.0
// The sessions of a spool, and what it loads when it is opened.
#include <algorithm>
#include <utility>

#include "client/sdk/spool/spool.h"
#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade::client {
namespace {

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
    // The process may have ended after the acknowledgement and before Trim.
    ENFILADE_RETURN_IF_ERROR(Trim(row));
  }
  Publish();
  return absl::OkStatus();
}

absl::StatusOr<Spool::SessionRow*> Spool::RowOf(const SessionId& id) {
  const auto row = sessions_.find(id.value());
  if (row == sessions_.end()) return NotFound("{}: the spool has no session {}", path_, id.value());
  return &row->second;
}

absl::Status Spool::CreateSession(const SpoolSession& session) {
  MutexLock writing(writer_mutex_);
  if (sessions_.contains(session.id.value())) {
    return AlreadyExists("{}: the spool already has a session {}", path_, session.id.value());
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
  ENFILADE_RETURN_IF_ERROR(insert.Step().status());  // steps past the last row, which commits
  SpoolSession fresh = session;
  fresh.last_sequence = fresh.acknowledged_sequence = 0;
  fresh.finished = fresh.closed = false;
  sessions_[session.id.value()] = {key, std::move(fresh)};
  Publish();
  return absl::OkStatus();
}

absl::Status Spool::SetEntry(const SessionId& id, const std::string& map, const sensor::SessionEntry& entry) {
  MutexLock writing(writer_mutex_);
  ENFILADE_ASSIGN_OR_RETURN(SessionRow* const row, RowOf(id));
  ENFILADE_ASSIGN_OR_RETURN(SqliteStatement update,
                            writer_.Prepare("UPDATE sessions SET map = ?, entry = ? WHERE key = ?"));
  const std::string bytes = sensor::Encode(entry);
  ENFILADE_RETURN_IF_ERROR(update.BindText(1, map).BindBlob(2, bytes).Bind(3, row->key).Run());
  row->session.map = map;
  row->session.entry = entry;
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

}  // namespace enfilade::client
