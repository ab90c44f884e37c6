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
  // For unacknowledged records and their blobs, bytes. The file on disk is a little larger.
  std::int64_t max_bytes = 4LL << 30;
  // Check the whole file for damage when it is opened (about a second per GB).
  bool check_on_open = true;
};

struct SpoolSession {
  SiteId site;
  SessionId id;
  RobotId robot;
  std::string map;  // display name or id; empty: only recorded, or the map follows from entry.previous
  sensor::SessionEntry entry;
  std::optional<Environment> environment;  // of a new map; unset: unknown
  std::string request_id;  // of CreateSession; the same after a restart, so that the session is created once
  std::string source;      // what is recorded (a log's hash, a driver's name); lets the owner find a session to resume
  // Set by the spool.
  std::int64_t last_sequence = 0;
  std::int64_t acknowledged_sequence = 0;
  bool finished = false;  // takes no more records
  bool closed = false;    // finished on the server, too

  std::int64_t pending() const { return last_sequence - acknowledged_sequence; }
};

// One record to append. `content`: the bytes of an image or a point cloud; they must match its BlobRef.
struct SpoolItem {
  sensor::RecordPayload payload;
  std::string content;
};
// When it was measured (a reading) or made (a report).
TimeNs TimeOf(const SpoolItem& item);

struct SpoolUsage {
  std::int64_t bytes = 0;  // used of max_bytes
  std::int64_t max_bytes = 0;
  std::int64_t records = 0;      // unacknowledged, of all sessions
  std::int64_t quarantined = 0;  // kept for inspection
  std::int64_t refused = 0;      // by this process, because the spool was full
};

struct QuarantinedRecord {
  sensor::Record record;
  std::string reason;
};

// Stores what a robot records on its disk until the server has acknowledged it. One SQLite file (WAL, synchronous =
// FULL) holds all sessions of a robot.
//
// Durability: when Append returns, the records are on disk (fsync of the write-ahead log); they survive a killed
// process and a power failure. Concurrent appends share one fsync.
//
// When full, it refuses the new record with RESOURCE_EXHAUSTED and keeps what it has: nothing is lost silently.
//
// Thread-safe. One process at a time. Further errors of every function: RESOURCE_EXHAUSTED (disk full), DATA_LOSS
// (damaged file), INTERNAL (I/O).
class Spool {
 public:
  // Creates the file if it is missing; its folder must exist. FAILED_PRECONDITION: in use by another process; written
  // by a newer program; another program's SQLite file. DATA_LOSS: damaged, or not an SQLite file.
  static absl::StatusOr<std::unique_ptr<Spool>> Open(const std::string& path, const SpoolOptions& options = {});

  // ALREADY_EXISTS.
  absl::Status CreateSession(const SpoolSession& session);
  // Where the robot of a session that is not uploaded yet entered which map. NOT_FOUND.
  absl::Status SetEntry(const SessionId& id, const std::string& map, const sensor::SessionEntry& entry);
  std::optional<SpoolSession> FindSession(const SessionId& id);
  // In the order of creation.
  std::vector<SpoolSession> ListSessions();
  // Deletes a session with its records, quarantined ones included. NOT_FOUND.
  absl::Status RemoveSession(const SessionId& id);

  // Appends all of the items or none, and returns the last one's sequence. NOT_FOUND; FAILED_PRECONDITION: the session
  // is finished; INVALID_ARGUMENT: a record that every server would refuse (Validate(Record)), or content that does not
  // match its BlobRef; RESOURCE_EXHAUSTED: the spool or the disk is full.
  absl::StatusOr<std::int64_t> Append(const SessionId& id, absl::Span<const SpoolItem> items);
  absl::StatusOr<std::int64_t> Append(const SessionId& id, sensor::RecordPayload payload);

  // The session takes no more records. NOT_FOUND.
  absl::Status MarkFinished(const SessionId& id);

  // For the uplink.

  // Records after `after_sequence` in order: at least one if there is one, at most `max_records`, and, blobs included,
  // about `max_bytes`. A record that is damaged on disk becomes a Withheld record that says so.
  absl::StatusOr<std::vector<sensor::Record>> ReadBatch(const SessionId& id, std::int64_t after_sequence,
                                                        std::int64_t max_records, std::int64_t max_bytes);
  // NOT_FOUND; DATA_LOSS: the bytes no longer match their hash.
  absl::StatusOr<std::string> ReadBlob(const sensor::BlobRef& blob);
  // The server has stored everything up to `sequence`, so it is deleted here. An older sequence than before changes
  // nothing; one beyond the last record means the last record.
  absl::Status Acknowledge(const SessionId& id, std::int64_t sequence);
  // Replaces a record that the server will never take by a Withheld record with `reason`; the record itself is kept for
  // inspection. NOT_FOUND: it is not pending; FAILED_PRECONDITION: it is already withheld.
  absl::Status Quarantine(const SessionId& id, std::int64_t sequence, const std::string& reason);
  absl::StatusOr<std::vector<QuarantinedRecord>> ListQuarantined(const SessionId& id);
  // The session is finished on the server, too. NOT_FOUND.
  absl::Status MarkClosed(const SessionId& id);

  // Waits until the session has records after `sequence` or is finished, until `deadline`, or until NotifyWaiters.
  void WaitForRecords(const SessionId& id, std::int64_t sequence, std::chrono::steady_clock::time_point deadline);
  // Likewise, until there is space for `bytes` more.
  void WaitForSpace(std::int64_t bytes, std::chrono::steady_clock::time_point deadline);
  void NotifyWaiters();

  SpoolUsage usage();
  const std::string& path() const { return path_; }

 private:
  struct SessionRow {
    std::int64_t key = 0;
    SpoolSession session;
  };
  // One Append in the group commit.
  struct Request {
    const SessionId& id;
    absl::Span<const SpoolItem> items;
    std::vector<std::string> payloads;  // encoded
    std::int64_t bytes = 0;
    bool done = false;
    absl::StatusOr<std::int64_t> result = 0;
  };

  // Added to each payload for its row, index and share of pages.
  static constexpr std::int64_t kRecordOverhead = 64;

  Spool(std::string path, const SpoolOptions& options, FileLock lock, SqliteDatabase writer, SqliteDatabase reader);
  absl::Status Load() ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);

  // Commits the requests in one transaction and sets their results.
  void CommitGroup(const std::vector<Request*>& group) ABSL_LOCKS_EXCLUDED(writer_mutex_, mutex_);
  absl::Status InsertAll(const std::vector<Request*>& group, std::map<std::string, std::int64_t>& last_sequences,
                         std::int64_t& new_bytes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  absl::Status Insert(const Request& request, std::int64_t key, std::int64_t first_sequence)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  // What the request adds to the bytes used: nothing for blobs that the spool already has.
  absl::StatusOr<std::int64_t> BytesNeeded(const Request& request) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  absl::StatusOr<SessionRow*> RowOf(const SessionId& id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  absl::Status Trim(SessionRow& row) ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_);
  // Publishes the sessions and the bytes used, and wakes those who wait for them.
  void Publish() ABSL_EXCLUSIVE_LOCKS_REQUIRED(writer_mutex_) ABSL_LOCKS_EXCLUDED(mutex_);

  const std::string path_;
  const SpoolOptions options_;
  const FileLock lock_;

  // Held while writing to the file.
  Mutex writer_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);
  SqliteDatabase writer_ ABSL_GUARDED_BY(writer_mutex_);
  std::map<std::string, SessionRow> sessions_ ABSL_GUARDED_BY(writer_mutex_);
  SpoolUsage usage_ ABSL_GUARDED_BY(writer_mutex_);

  Mutex reader_mutex_;
  SqliteDatabase reader_ ABSL_GUARDED_BY(reader_mutex_);

  // Never held during I/O.
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
