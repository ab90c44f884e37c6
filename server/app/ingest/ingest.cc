// SPDX-License-Identifier: Apache-2.0
#include "server/app/ingest/ingest.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

constexpr auto kWriteTimeout = std::chrono::seconds(30);
// Streams that share a transaction: more of them delay each acknowledgement.
constexpr std::size_t kMaxStreamsPerTransaction = 32;

}  // namespace

// Ingest's mutex guards all non-constant fields that have no mutex of their own.
class Ingest::Stream {
 public:
  Stream(convert::SessionName name, std::function<void(const IngestEvent&)> callback)
      : session(std::move(name)), on_event(std::move(callback)) {}

  // Serialised: RoomAgain may come from another thread than the stream's writer.
  void Notify(const IngestEvent& event) {
    MutexLock lock(event_mutex);
    if (!closed) on_event(event);
  }

  const convert::SessionName session;
  Mutex event_mutex;
  const std::function<void(const IngestEvent&)> on_event;
  bool closed ABSL_GUARDED_BY(event_mutex) = false;

  struct Entry {
    IngestItem item;
    std::int64_t bytes = 0;
  };
  std::deque<Entry> entries;
  std::int64_t bytes = 0;  // of the entries and of what is being written
  bool writing = false;
  bool paused = false;  // Offer returned false
  bool failed = false;  // later items are dropped: the client sends them again
  bool drain_notified = false;
};

// What one writer does for one stream in one round: one blob, or several batches and refusals in their order.
struct Ingest::Work {
  std::shared_ptr<Stream> stream;
  std::vector<Stream::Entry> entries;
  std::vector<IngestEvent> events;
};

Ingest::Ingest(const ServerOptions::Ingest& options, const storage::RecordStore& records,
               const storage::BlobStore& blobs, Metrics& metrics, OnStored on_stored)
    : options_(options), records_(records), blobs_(blobs), metrics_(metrics), on_stored_(std::move(on_stored)) {
  for (int i = 0; i < options_.writers; ++i) writers_.emplace_back([this] { Run(); });
}

Ingest::~Ingest() {
  {
    MutexLock lock(mutex_);
    stopping_ = true;
    changed_.NotifyAll();
  }
  for (std::thread& writer : writers_) writer.join();
}

std::shared_ptr<Ingest::Stream> Ingest::Open(const convert::SessionName& session,
                                             std::function<void(const IngestEvent&)> on_event) {
  auto stream = std::make_shared<Stream>(session, std::move(on_event));
  MutexLock lock(mutex_);
  streams_.insert(stream);
  if (draining_) MakeReady(stream);
  metrics_.AddStreamsOpen(1);
  return stream;
}

bool Ingest::Offer(const std::shared_ptr<Stream>& stream, IngestItem item, std::size_t bytes) {
  const auto size = static_cast<std::int64_t>(bytes);
  metrics_.AddIngestBuffered(size);
  MutexLock lock(mutex_);
  const bool idle = stream->entries.empty() && !stream->writing;
  stream->entries.push_back({std::move(item), size});
  stream->bytes += size;
  total_bytes_ += size;
  if (idle) MakeReady(stream);
  stream->paused = stream->bytes > options_.stream_buffer_bytes || total_bytes_ > options_.total_buffer_bytes;
  return !stream->paused;
}

void Ingest::Close(const std::shared_ptr<Stream>& stream) {
  {
    MutexLock lock(stream->event_mutex);
    if (stream->closed) return;
    stream->closed = true;
  }
  metrics_.AddStreamsOpen(-1);
  MutexLock lock(mutex_);
  streams_.erase(stream);
}

void Ingest::Drain() {
  MutexLock lock(mutex_);
  draining_ = true;
  for (const auto& stream : streams_) {
    if (stream->entries.empty() && !stream->writing) MakeReady(stream);
  }
}

void Ingest::MakeReady(const std::shared_ptr<Stream>& stream) {
  ready_.push_back(stream);
  changed_.NotifyOne();
}

void Ingest::Run() {
  while (true) {
    std::vector<Work> work;
    {
      MutexLock lock(mutex_);
      while (!stopping_ && ready_.empty()) changed_.Wait(mutex_);
      if (ready_.empty()) return;
      work = TakeWork();
    }
    Write(work);
    Return(work);
  }
}

// The next items of the streams that have waited longest, up to the size of one transaction.
std::vector<Ingest::Work> Ingest::TakeWork() {
  std::vector<Work> work;
  std::int64_t bytes = 0;
  while (!ready_.empty() && work.size() < kMaxStreamsPerTransaction && bytes < options_.transaction_bytes) {
    const std::shared_ptr<Stream> stream = std::move(ready_.front());
    ready_.pop_front();
    if (stream->writing) continue;  // queued twice, by Drain
    stream->writing = true;
    Work next{stream, {}, {}};
    while (!stream->entries.empty() && bytes < options_.transaction_bytes) {
      const bool is_blob = std::holds_alternative<IngestBlob>(stream->entries.front().item);
      if (is_blob && !next.entries.empty()) break;
      bytes += stream->entries.front().bytes;
      next.entries.push_back(std::move(stream->entries.front()));
      stream->entries.pop_front();
      if (is_blob) break;
    }
    work.push_back(std::move(next));
  }
  return work;
}

void Ingest::Write(std::vector<Work>& work) {
  WriteBlobs(work);
  WriteBatches(work);
  for (Work& one : work) {
    for (const IngestEvent& event : one.events) one.stream->Notify(event);
  }
}

void Ingest::WriteBlobs(std::vector<Work>& work) {
  for (Work& one : work) {
    if (one.entries.size() != 1 || one.stream->failed) continue;
    auto* blob = std::get_if<IngestBlob>(&one.entries.front().item);
    if (!blob) continue;
    const absl::Status status = WriteBlob(one.stream->session.site, *blob);
    if (!status.ok()) one.events.push_back(Failed{status});
  }
}

absl::Status Ingest::WriteBlob(const SiteId& site, IngestBlob& blob) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string data, blob.data.Take());
  const storage::BlobView view{blob.sha256, data};
  return blobs_.Put(storage::CallContext::WithTimeout(kWriteTimeout), site, absl::MakeConstSpan(&view, 1));
}

void Ingest::WriteBatches(std::vector<Work>& work) {
  struct Origin {
    Work* work;
    std::size_t event;  // the place of the batch's result in work->events
  };
  std::vector<storage::RecordBatch> batches;
  std::vector<Origin> origins;
  for (Work& one : work) {
    if (one.stream->failed) continue;
    for (const Stream::Entry& entry : one.entries) {
      if (const auto* batch = std::get_if<IngestBatch>(&entry.item)) {
        batches.push_back({one.stream->session.site, one.stream->session.session, batch->records, {}});
        origins.push_back({&one, one.events.size()});
        one.events.emplace_back(Stored{});
      } else if (const auto* refusal = std::get_if<Refusal>(&entry.item)) {
        one.events.emplace_back(*refusal);
        metrics_.CountBatchRefused();
      }
    }
  }
  if (batches.empty()) return;

  const auto results = records_.AppendGroup(storage::CallContext::WithTimeout(kWriteTimeout), batches);
  for (std::size_t i = 0; i < batches.size(); ++i) {
    origins[i].work->events[origins[i].event] = ReportResult(batches[i], results[i]);
    if (results[i].ok() && results[i]->inserted > 0) on_stored_(batches[i].site, batches[i].session);
  }
}

IngestEvent Ingest::ReportResult(const storage::RecordBatch& batch,
                                 const absl::StatusOr<storage::AppendResult>& result) {
  if (result.ok()) {
    metrics_.CountRecordsStored(result->inserted, result->duplicates);
    return Stored{result->acknowledged_sequence};
  }
  const absl::Status& status = result.status();
  if (const std::int64_t sequence = storage::RefusedSequenceOf(status); sequence > 0) {
    metrics_.CountBatchRefused();
    const auto reason =
        absl::IsAlreadyExists(status) ? Refusal::Reason::kConflictingRecord : Refusal::Reason::kInvalidRecord;
    return Refusal{batch.records.front().sequence, sequence, reason, std::string(status.message())};
  }
  spdlog::warn("ingest: a batch of session {} was not stored: {}", batch.session.value(), status.ToString());
  return Failed{status};
}

// Releases the streams: queues those that have new items, and notifies those that may continue.
void Ingest::Return(const std::vector<Work>& work) {
  std::vector<std::shared_ptr<Stream>> drained;
  std::vector<std::shared_ptr<Stream>> with_room;
  std::int64_t written = 0;
  {
    MutexLock lock(mutex_);
    for (const Work& one : work) {
      Stream& stream = *one.stream;
      for (const Stream::Entry& entry : one.entries) {
        stream.bytes -= entry.bytes;
        written += entry.bytes;
      }
      stream.failed = stream.failed || std::any_of(one.events.begin(), one.events.end(), [](const IngestEvent& event) {
                        return std::holds_alternative<Failed>(event);
                      });
      stream.writing = false;
      if (!stream.entries.empty()) {
        MakeReady(one.stream);
      } else if (draining_ && !stream.drain_notified) {
        stream.drain_notified = true;
        drained.push_back(one.stream);
      }
    }
    total_bytes_ -= written;
    with_room = StreamsWithRoomAgain();
  }
  metrics_.AddIngestBuffered(-written);
  for (const auto& stream : with_room) stream->Notify(RoomAgain{});
  for (const auto& stream : drained) stream->Notify(Drained{});
}

std::vector<std::shared_ptr<Ingest::Stream>> Ingest::StreamsWithRoomAgain() {
  std::vector<std::shared_ptr<Stream>> streams;
  if (total_bytes_ > options_.total_buffer_bytes) return streams;
  for (const auto& stream : streams_) {
    if (!stream->paused || stream->bytes > options_.stream_buffer_bytes / 2) continue;
    stream->paused = false;
    streams.push_back(stream);
  }
  return streams;
}

}  // namespace enfilade::server
