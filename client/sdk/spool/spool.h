// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "client/sdk/spool/file_lock.h"
#include "client/sdk/spool/sqlite.h"
#include "core/base/environment.h"
#include "core/base/ids.h"
#include "core/base/mutex.h"
#include "core/sensor/record.h"
#include "core/sensor/session_entry.h"

namespace enfilade::client {

struct SpoolOptions {
  // Of unacknowledged records and their blobs together, bytes. The file on disk is a little larger.
  std::int64_t max_bytes = 4LL << 30;
  // Looks through the whole file for damage when it is opened (about a second per GB).
  bool check_on_open = true;
};

struct SpoolSession {
  SiteId site;
  SessionId id;
  RobotId robot;
  std::string map;  // by display name or id; empty: only recorded, or the map follows from entry.previous
  sensor::SessionEntry entry;
  std::optional<Environment> environment;  // of a map that is made for it; unset: not known
  std::string request_id;  // of CreateSession: the same after a restart, so that the session is created once
  std::string source;      // what is recorded (a log's hash, a driver's name): the owner's, to tell whether to go on
  // Set by the spool.
  std::int64_t last_sequence = 0;
  std::int64_t acknowledged_sequence = 0;
  bool finished = false;  // no more records will be appended
  bool closed = false;    // the server knows that it is finished

  std::int64_t pending() const { return last_sequence - acknowledged_sequence; }
};

// One thing to be recorded. `content`: the bytes of an image or point cloud, which its BlobRef must fit.
struct SpoolItem {
  sensor::RecordPayload payload;
  std::string content;
};
// When it was measured or, of a report, made.
TimeNs TimeOf(const SpoolItem& item);

struct SpoolUsage {
  std::int64_t bytes = 0;  // counts against max_bytes
  std::int64_t max_bytes = 0;
  std::int64_t records = 0;      // unacknowledged, all sessions
  std::int64_t quarantined = 0;  // kept for inspection
  std::int64_t refused = 0;      // by this process, because the spool was full
};

struct QuarantinedRecord {
  sensor::Record record;
  std::string reason;
};

// Keeps what a robot records on its disk until the server has acknowledged it. One SQLite file (WAL, synchronous =
// FULL) for all of a robot's sessions.
//
// Durability point: Append returns when the records are on disk (fsync of the write-ahead log); they survive a killed
// process and a lost power supply. Appends of several threads that meet share one fsync.
//
// Full: the new record is refused with RESOURCE_EXHAUSTED, what is kept stays: nothing is dropped silently.
//
// Thread-safe. One process at a time. Errors beside those named: RESOURCE_EXHAUSTED (disk full), DATA_LOSS (damaged
// file), INTERNAL (I/O).
class Spool {
 public:
  // Creates the file where it is missing; its folder must exist. FAILED_PRECONDITION: in use by another process; made
  // by a newer program; another program's SQLite file. DATA_LOSS: damaged, or no SQLite file.
  static absl::StatusOr<std::unique_ptr<Spool>> Open(const std::string& path, const SpoolOptions& options = {});

  // ALREADY_EXISTS.
  absl::Status CreateSession(const SpoolSession& session);
  std::optional<SpoolSession> FindSession(const SessionId& id);
  // In the order in which they were created.
  std::vector<SpoolSession> ListSessions();
  // Drops a session with all that the spool holds of it, quarantined records included. NOT_FOUND.
  absl::Status RemoveSession(const SessionId& id);

  // Appends all of the items or none, and returns the last one's sequence. NOT_FOUND; FAILED_PRECONDITION where the
  // session is finished; INVALID_ARGUMENT for what no server would take (Validate(Record), a content that does not fit
  // its BlobRef); RESOURCE_EXHAUSTED where the spool or the disk is full.
  absl::StatusOr<std::int64_t> Append(const SessionId& id, absl::Span<const SpoolItem> items);
  absl::StatusOr<std::int64_t> Append(const SessionId& id, sensor::RecordPayload payload);

  // No more records will come. NOT_FOUND.
  absl::Status MarkFinished(const SessionId& id);

  // For the uplink.

  // Records after `after_sequence` in order, at least one where there is one, together at most `max_records` and, blobs
  // included, about `max_bytes`. A record that is damaged on disk comes as Withheld, saying so.
  absl::StatusOr<std::vector<sensor::Record>> ReadBatch(const SessionId& id, std::int64_t after_sequence,
                                                        std::int64_t max_records, std::int64_t max_bytes);
  // NOT_FOUND; DATA_LOSS where the bytes no longer fit their hash.
  absl::StatusOr<std::string> ReadBlob(const sensor::BlobRef& blob);
  // Everything up to `sequence` is stored by the server and is dropped here. Never goes back; beyond the last sequence
  // it means the last one.
  absl::Status Acknowledge(const SessionId& id, std::int64_t sequence);
  // Puts a Withheld record with `reason` in the place of one that the server refuses for good; the record itself is
  // kept aside for inspection. NOT_FOUND where it is not pending; FAILED_PRECONDITION where it is withheld already.
  absl::Status Quarantine(const SessionId& id, std::int64_t sequence, const std::string& reason);
  absl::StatusOr<std::vector<QuarantinedRecord>> ListQuarantined(const SessionId& id);
  // The server has been told that the session is finished. NOT_FOUND.
  absl::Status MarkClosed(const SessionId& id);

  // Waits until the session has records after `sequence`, is finished, or `deadline` has passed; NotifyWaiters ends the
  // wait, too.
  void WaitForRecords(const SessionId& id, std::int64_t sequence, std::chrono::steady_clock::time_point deadline);
  // Waits until less than max_bytes are used after `bytes` more, likewise.
  void WaitForSpace(std::int64_t bytes, std::chrono::steady_clock::time_point deadline);
  void NotifyWaiters();

  SpoolUsage usage();
  const std::string& path() const { return path_; }

 private:
  struct SessionRow {
    std::int64_t key = 0;
    SpoolSession session;
  };
  // One Append on its way through the group commit.
  struct Request {
    const SessionId& id;
    absl::Span<const SpoolItem> items;
    std::vector<std::string> payloads;  // encoded
    std::int64_t bytes = 0;
    bool done = false;
    absl::StatusOr<std::int64_t> result = 0;
  };

  // Counted per record beside its payload: row, index, page overhead.
  static constexpr std::int64_t kRecordOverhead = 64;

  Spool(std::string path, const SpoolOptions& options, FileLock lock, SqliteDatabase writer, SqliteDatabase reader);
  absl::Status Load() ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);

  // Commits the requests in one transaction and sets their results.
  void CommitGroup(const std::vector<Request*>& group) ABSL_LOCKS_EXCLUDED(writer_mutex_, mutex_);
  absl::Status InsertAll(const std::vector<Request*>& group, std::map<std::string, std::int64_t>& last_sequences,
                         std::int64_t& new_bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  absl::Status Insert(const Request& request, std::int64_t key, std::int64_t first_sequence)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  // What the request adds to the bytes used: blobs that the spool holds already cost nothing.
  absl::StatusOr<std::int64_t> BytesNeeded(const Request& request) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  absl::StatusOr<SessionRow*> RowOf(const SessionId& id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  absl::Status Trim(SessionRow& row) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  // Tells waiters what has changed.
  void Publish() ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_) ABSL_LOCKS_EXCLUDED(mutex_);

  const std::string path_;
  const SpoolOptions options_;
  const FileLock lock_;

  // Held while the file is written.
  Mutex writer_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);
  SqliteDatabase writer_ ABSL_GUARDED_BY(writer_mutex_);
  std::map<std::string, SessionRow> sessions_ ABSL_GUARDED_BY(writer_mutex_);
  SpoolUsage usage_ ABSL_GUARDED_BY(writer_mutex_);

  Mutex reader_mutex_;
  SqliteDatabase reader_ ABSL_GUARDED_BY(reader_mutex_);

  // Held for moments only.
  Mutex mutex_;
  CondVar changed_;
  std::vector<Request*> queue_ ABSL_GUARDED_BY(mutex_);
  bool committing_ ABSL_GUARDED_BY(mutex_) = false;
  struct Published {
    std::int64_t key = 0;
    std::int64_t last_sequence = 0;
    bool finished = false;
  };
  std::map<std::string, Published> published_ ABSL_GUARDED_BY(mutex_);
  std::int64_t published_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  std::int64_t wakes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace enfilade::client
