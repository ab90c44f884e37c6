// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "core/sensor/record.h"
#include "proto/convert/names.h"
#include "server/app/runtime/metrics.h"
#include "server/app/uploads/uploaded_file.h"
#include "server/config/server_options.h"
#include "storage/maps/blob_store.h"
#include "storage/sessions/record_store.h"

namespace enfilade::server {

// A batch of which nothing is stored.
struct Refusal {
  enum class Reason { kInvalidRecord, kConflictingRecord, kInvalidBatch };

  std::int64_t first_sequence = 0;
  std::int64_t sequence = 0;  // of the invalid record; 0: the batch as a whole is invalid
  Reason reason = Reason::kInvalidBatch;
  std::string message;
};

// The input of a stream, processed in order.
struct IngestBatch {
  std::vector<sensor::Record> records;
};
struct IngestBlob {
  std::string sha256;
  UploadedFile data;
};
using IngestItem = std::variant<IngestBatch, IngestBlob, Refusal>;

// The results.
struct Stored {
  std::int64_t acknowledged_sequence = 0;
};
struct Failed {
  absl::Status status;  // the stream cannot continue
};
struct RoomAgain {};  // the stream may continue after Offer returned false
struct Drained {};    // the server is shutting down: everything offered is stored, and nothing more is accepted
using IngestEvent = std::variant<Stored, Refusal, Failed, RoomAgain, Drained>;

// Collects the batches of many streams and stores them in few transactions: while one transaction is written, the
// batches for the next one accumulate. Bounded: a stream that is ahead of the database must wait. Thread-safe.
class Ingest {
 public:
  class Stream;

  // Called after every commit for each session that got new records, which are then ready to be mapped.
  using OnStored = std::function<void(const SiteId& site, const SessionId& session)>;
  Ingest(const ServerOptions::Ingest& options, const storage::RecordStore& records, const storage::BlobStore& blobs,
         Metrics& metrics, OnStored on_stored);
  // All streams must be closed.
  ~Ingest();
  Ingest(const Ingest&) = delete;
  Ingest& operator=(const Ingest&) = delete;

  // `on_event` is called from writer threads, one call at a time per stream. It must not block.
  std::shared_ptr<Stream> Open(const convert::SessionName& session, std::function<void(const IngestEvent&)> on_event);
  // Accepts the item in any case. If it returns false, the caller must wait for RoomAgain before the next item.
  bool Offer(const std::shared_ptr<Stream>& stream, IngestItem item, std::size_t bytes);
  // No event is delivered after it returns, except one that another thread is just delivering. Items that were offered
  // before are still stored.
  void Close(const std::shared_ptr<Stream>& stream);

  // Every open stream, and every stream opened later, receives Drained when all its items are stored.
  void Drain();

 private:
  struct Work;

  void MakeReady(const std::shared_ptr<Stream>& stream) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Run();
  std::vector<Work> TakeWork() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Write(std::vector<Work>& work);
  void WriteBlobs(std::vector<Work>& work);
  absl::Status WriteBlob(const SiteId& site, IngestBlob& blob);
  void WriteBatches(std::vector<Work>& work);
  // Counts and logs the result.
  IngestEvent ReportResult(const storage::RecordBatch& batch, const absl::StatusOr<storage::AppendResult>& result);
  void Return(const std::vector<Work>& work);
  std::vector<std::shared_ptr<Stream>> StreamsWithRoomAgain() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const ServerOptions::Ingest options_;
  const storage::RecordStore& records_;
  const storage::BlobStore& blobs_;
  Metrics& metrics_;
  const OnStored on_stored_;

  Mutex mutex_;
  CondVar changed_;  // ready_ or stopping_
  std::set<std::shared_ptr<Stream>> streams_ ABSL_GUARDED_BY(mutex_);
  std::deque<std::shared_ptr<Stream>> ready_ ABSL_GUARDED_BY(mutex_);  // have items, but no writer
  std::int64_t total_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> writers_;
};

}  // namespace enfilade::server
