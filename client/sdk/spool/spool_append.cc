// SPDX-License-Identifier: Apache-2.0
// How a spool appends: the group commit, and the waits for new records and for space.
#include <algorithm>
#include <set>
#include <utility>

#include "client/sdk/spool/spool.h"
#include "client/sdk/spool/spool_schema.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/sensor/record_codec.h"

namespace enfilade::client {
namespace {

absl::Status Check(const SpoolItem& item) {
  const sensor::Record record{1, item.payload};
  ENFILADE_RETURN_IF_ERROR(sensor::Validate(record));
  const sensor::BlobRef* blob = sensor::FindBlob(record);
  if (!blob && item.content.empty()) return absl::OkStatus();
  if (!blob) return InvalidArgument("the record has no blob, but {} bytes of content", item.content.size());
  if (static_cast<std::int64_t>(item.content.size()) != blob->size) {
    return InvalidArgument("content.size_bytes is {}, but there are {} bytes", blob->size, item.content.size());
  }
  if (Sha256(item.content) != blob->sha256)
    return InvalidArgument("content.sha256 differs from the SHA-256 of the bytes");
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::int64_t> Spool::Append(const SessionId& id, sensor::RecordPayload payload) {
  const SpoolItem item{std::move(payload), {}};
  return Append(id, absl::MakeConstSpan(&item, 1));
}

absl::StatusOr<std::int64_t> Spool::Append(const SessionId& id, absl::Span<const SpoolItem> items) {
  if (items.empty()) return InvalidArgument("there is nothing to append");
  Request request{id, items, {}, 0, false, 0};
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (absl::Status status = Check(items[i]); !status.ok()) {
      return items.size() == 1 ? status : WithContext(status, fmt::format("item {}", i));
    }
    request.payloads.push_back(sensor::EncodePayload({1, items[i].payload}));
    request.bytes += static_cast<std::int64_t>(request.payloads.back().size()) + kRecordOverhead;
  }
  // A thread that finds no commit running commits all waiting requests; those that arrive meanwhile share the next one.
  std::vector<Request*> group;
  {
    MutexLock lock(mutex_);
    queue_.push_back(&request);
    while (committing_ && !request.done) changed_.Wait(mutex_);
    if (request.done) return request.result;
    committing_ = true;
    group.swap(queue_);
  }
  CommitGroup(group);
  MutexLock lock(mutex_);
  for (Request* member : group) member->done = true;
  committing_ = false;
  changed_.NotifyAll();
  return request.result;
}

void Spool::CommitGroup(const std::vector<Request*>& group) {
  MutexLock writing(writer_mutex_);
  std::map<std::string, std::int64_t> last_sequences;
  std::int64_t new_bytes = 0;
  const absl::Status status = InsertAll(group, last_sequences, new_bytes);
  if (!status.ok()) {
    for (Request* request : group) {
      if (request->result.ok()) request->result = status;
    }
    return;
  }
  for (const auto& [id, last] : last_sequences) {
    SpoolSession& session = sessions_.at(id).session;
    usage_.records += last - session.last_sequence;
    session.last_sequence = last;
  }
  usage_.bytes += new_bytes;
  Publish();
}

absl::Status Spool::InsertAll(const std::vector<Request*>& group, std::map<std::string, std::int64_t>& last_sequences,
                              std::int64_t& new_bytes) {
  ENFILADE_ASSIGN_OR_RETURN(SqliteTransaction transaction, SqliteTransaction::Begin(writer_));
  for (Request* request : group) {
    const absl::StatusOr<SessionRow*> row = RowOf(request->id);
    if (!row.ok() || (*row)->session.finished) {
      request->result = row.ok() ? FailedPrecondition("{}: session {} is finished and takes no more records", path_,
                                                      request->id.value())
                                 : row.status();
      continue;
    }
    const std::string& id = request->id.value();
    const auto known = last_sequences.find(id);
    const std::int64_t last = known == last_sequences.end() ? (*row)->session.last_sequence : known->second;
    ENFILADE_ASSIGN_OR_RETURN(const std::int64_t needed, BytesNeeded(*request));
    if (usage_.bytes + new_bytes + needed > options_.max_bytes) {
      usage_.refused += static_cast<std::int64_t>(request->items.size());
      request->result = ResourceExhausted(
          "{}: the spool is full: {} of {} bytes are used and {} more are needed; the new record is refused, and what "
          "the spool holds stays until the server has it",
          path_, usage_.bytes + new_bytes, options_.max_bytes, needed);
      continue;
    }
    ENFILADE_RETURN_IF_ERROR(Insert(*request, (*row)->key, last + 1));
    new_bytes += needed;
    last_sequences[id] = last + static_cast<std::int64_t>(request->items.size());
    request->result = last_sequences[id];
  }
  if (last_sequences.empty()) return absl::OkStatus();  // all were refused
  ENFILADE_ASSIGN_OR_RETURN(SqliteStatement update,
                            writer_.Prepare("UPDATE sessions SET last_sequence = ? WHERE id = ?"));
  for (const auto& [id, last] : last_sequences) ENFILADE_RETURN_IF_ERROR(update.Bind(1, last).BindText(2, id).Run());
  return transaction.Commit();
}

absl::StatusOr<std::int64_t> Spool::BytesNeeded(const Request& request) {
  std::int64_t bytes = request.bytes;
  std::set<std::string> counted;
  for (const SpoolItem& item : request.items) {
    const sensor::Record record{1, item.payload};
    const sensor::BlobRef* blob = sensor::FindBlob(record);
    if (!blob || !counted.insert(blob->sha256).second) continue;
    ENFILADE_ASSIGN_OR_RETURN(SqliteStatement stored, writer_.Prepare("SELECT 1 FROM blobs WHERE sha256 = ?"));
    stored.BindBlob(1, blob->sha256);
    ENFILADE_ASSIGN_OR_RETURN(const bool found, stored.Step());
    if (!found) bytes += blob->size;
  }
  return bytes;
}

absl::Status Spool::Insert(const Request& request, std::int64_t key, std::int64_t first_sequence) {
  ENFILADE_ASSIGN_OR_RETURN(
      SqliteStatement insert,
      writer_.Prepare("INSERT INTO records (session, sequence, kind, payload, crc, blob) VALUES (?, ?, ?, ?, ?, ?)"));
  for (std::size_t i = 0; i < request.items.size(); ++i) {
    const SpoolItem& item = request.items[i];
    const sensor::Record record{first_sequence + static_cast<std::int64_t>(i), item.payload};
    const std::string& payload = request.payloads[i];
    insert.Bind(1, key).Bind(2, record.sequence).Bind(3, static_cast<std::int64_t>(sensor::KindOf(record)));
    insert.BindBlob(4, payload).Bind(5, Crc(payload)).BindNull(6);
    if (const sensor::BlobRef* blob = sensor::FindBlob(record)) {
      insert.BindBlob(6, blob->sha256);
      ENFILADE_ASSIGN_OR_RETURN(SqliteStatement store,
                                writer_.Prepare("INSERT OR IGNORE INTO blobs (sha256, content) VALUES (?, ?)"));
      ENFILADE_RETURN_IF_ERROR(store.BindBlob(1, blob->sha256).BindBlob(2, item.content).Run());
    }
    ENFILADE_RETURN_IF_ERROR(insert.Run());
  }
  return absl::OkStatus();
}

void Spool::Publish() {
  MutexLock lock(mutex_);
  published_.clear();
  for (const auto& [id, row] : sessions_) published_[id] = {row.key, row.session.last_sequence, row.session.finished};
  published_bytes_ = usage_.bytes;
  changed_.NotifyAll();
}

void Spool::WaitForRecords(const SessionId& id, std::int64_t sequence, std::chrono::steady_clock::time_point deadline) {
  MutexLock lock(mutex_);
  const std::int64_t wakes = wakes_;
  while (wakes_ == wakes && std::chrono::steady_clock::now() < deadline) {
    const auto session = published_.find(id.value());
    if (session == published_.end() || session->second.finished || session->second.last_sequence > sequence) return;
    changed_.WaitUntil(mutex_, deadline);
  }
}

void Spool::WaitForSpace(std::int64_t bytes, std::chrono::steady_clock::time_point deadline) {
  MutexLock lock(mutex_);
  const std::int64_t wakes = wakes_;
  while (wakes_ == wakes && published_bytes_ + bytes > options_.max_bytes &&
         std::chrono::steady_clock::now() < deadline) {
    changed_.WaitUntil(mutex_, deadline);
  }
}

void Spool::NotifyWaiters() {
  MutexLock lock(mutex_);
  ++wakes_;
  changed_.NotifyAll();
}

}  // namespace enfilade::client
