// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <random>
#include <thread>

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "server/app/ingest/ingest.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/server/app/test_values.h"

namespace enfilade::server {

inline UploadSpace test_uploads({.directory = ::testing::TempDir(), .memory_bytes = 1 << 20, .disk_bytes = 1 << 20});

inline UploadedFile Uploaded(const std::string& bytes) {
  UploadedFile file(test_uploads);
  EXPECT_OK(file.Append(bytes));
  return file;
}

inline const SiteId kSite("campus");

// A record store that can hold back its transactions, fail them, and that remembers them.
class HeldRecordStore final : public storage::RecordStore {
 public:
  explicit HeldRecordStore(const storage::RecordStore& store) : store_(store) {}

  std::vector<absl::StatusOr<storage::AppendResult>> AppendGroup(
      const storage::CallContext& context, absl::Span<const storage::RecordBatch> batches) const override {
    absl::Status failure;
    {
      MutexLock lock(mutex_);
      std::vector<std::string>& transaction = transactions_.emplace_back();
      for (const storage::RecordBatch& batch : batches) {
        transaction.push_back(fmt::format("{}:{}", batch.session.value(), batch.records.front().sequence));
      }
      changed_.NotifyAll();
      while (held_) changed_.Wait(mutex_);
      failure = std::exchange(failure_, absl::OkStatus());
    }
    if (failure.ok()) return store_.AppendGroup(context, batches);
    return {batches.size(), failure};
  }
  absl::StatusOr<std::vector<sensor::Record>> Read(const storage::CallContext& context, const SiteId& site,
                                                   const SessionId& session, std::int64_t from_sequence,
                                                   std::int64_t max_bytes) const override {
    return store_.Read(context, site, session, from_sequence, max_bytes);
  }
  absl::StatusOr<std::vector<sensor::Record>> ReadSelected(const storage::CallContext& context, const SiteId& site,
                                                           const SessionId& session,
                                                           const storage::RecordSelection& selection) const override {
    return store_.ReadSelected(context, site, session, selection);
  }
  absl::StatusOr<std::vector<sensor::Record>> ReadEach(const storage::CallContext& context, const SiteId& site,
                                                       const SessionId& session,
                                                       const std::vector<std::int64_t>& sequences) const override {
    return store_.ReadEach(context, site, session, sequences);
  }

  void Hold() {
    MutexLock lock(mutex_);
    held_ = true;
  }
  void LetGo() {
    MutexLock lock(mutex_);
    held_ = false;
    changed_.NotifyAll();
  }
  // The next transaction fails with `failure`.
  void FailNext(absl::Status failure) {
    MutexLock lock(mutex_);
    failure_ = std::move(failure);
  }
  // The first batches of each transaction as "session:sequence", once `count` transactions have begun.
  std::vector<std::vector<std::string>> AwaitTransactions(std::size_t count) const {
    MutexLock lock(mutex_);
    while (transactions_.size() < count) changed_.Wait(mutex_);
    return transactions_;
  }

 private:
  const storage::RecordStore& store_;
  mutable Mutex mutex_;
  mutable CondVar changed_;
  mutable std::vector<std::vector<std::string>> transactions_;
  bool held_ = false;
  mutable absl::Status failure_;
};

std::string Describe(const IngestEvent& event) {
  if (const auto* stored = std::get_if<Stored>(&event)) return fmt::format("stored {}", stored->acknowledged_sequence);
  if (const auto* refusal = std::get_if<Refusal>(&event)) {
    const char* const reason = refusal->reason == Refusal::Reason::kConflictingRecord ? "conflicting"
                               : refusal->reason == Refusal::Reason::kInvalidRecord   ? "invalid record"
                                                                                      : "invalid batch";
    return fmt::format("refused {} of {}: {}", refusal->sequence, refusal->first_sequence, reason);
  }
  if (const auto* failed = std::get_if<Failed>(&event)) return absl::StatusCodeToString(failed->status.code());
  return std::holds_alternative<RoomAgain>(event) ? "room again" : "drained";
}

// A stream and the events that it has received.
class Client {
 public:
  Client(Ingest& ingest, const std::string& session)
      : ingest_(ingest), stream_(ingest.Open({kSite, SessionId(session)}, [this](const IngestEvent& event) {
          MutexLock lock(mutex_);
          events_.push_back(Describe(event));
          changed_.NotifyAll();
        })) {}
  ~Client() { Close(); }

  bool Send(std::int64_t first, std::int64_t last, std::size_t bytes = 1) {
    return ingest_.Offer(stream_, IngestBatch{OdometryRecords(first, last)}, bytes);
  }
  bool Offer(IngestItem item, std::size_t bytes = 1) { return ingest_.Offer(stream_, std::move(item), bytes); }
  void Close() { ingest_.Close(stream_); }

  std::vector<std::string> AwaitEvents(std::size_t count) {
    MutexLock lock(mutex_);
    while (events_.size() < count) changed_.Wait(mutex_);
    return events_;
  }
  void Await(const std::string& event) {
    MutexLock lock(mutex_);
    while (std::find(events_.begin(), events_.end(), event) == events_.end()) changed_.Wait(mutex_);
  }
  std::vector<std::string> events() {
    MutexLock lock(mutex_);
    return events_;
  }

 private:
  Ingest& ingest_;
  Mutex mutex_;
  CondVar changed_;
  std::vector<std::string> events_;
  const std::shared_ptr<Ingest::Stream> stream_;  // the last member: events come from here on
};

class IngestTest : public ::testing::Test {
 protected:
  IngestTest() {
    stores_.database.AddSite(kSite);
    stores_.database.AddRobot(kSite, RobotId("r"));
    EXPECT_OK(stores_.maps.Create(Soon(), MakeMap(kSite, "m"), ""));
    options_.writers = 1;
  }

  std::string NewSession(const std::string& id) {
    EXPECT_OK(stores_.sessions.Create(Soon(), MakeSession(kSite, id, "m"), ""));
    return id;
  }
  void Start() {
    ingest_.emplace(options_, records_, stores_.blobs, *metrics_,
                    [this](const SiteId&, const SessionId&) { ++stored_; });
  }
  std::int64_t Acknowledged(const std::string& session) {
    return stores_.sessions.Get(Soon(), kSite, SessionId(session))->acknowledged_sequence;
  }

  testing::InMemoryStores stores_;
  HeldRecordStore records_{stores_.records};
  const std::unique_ptr<Metrics> metrics_ = *Metrics::Create("");
  ServerOptions::Ingest options_;
  std::atomic<int> stored_{0};  // calls of on_stored
  std::optional<Ingest> ingest_;
};

}  // namespace enfilade::server
