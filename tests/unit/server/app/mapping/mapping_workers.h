// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/app/mapping/mapping.h"
#include "tests/unit/server/app/mapping/mapping_fixture.h"

namespace enfilade::server {

// Counts how often work is looked for, and a session's results are loaded.
class CountingMappingStore final : public storage::MappingStore {
 public:
  explicit CountingMappingStore(const storage::MappingStore& store) : store_(store) {}

  int looks() const { return looks_; }
  int loads() const { return loads_; }
  int commits() const { return commits_; }
  std::int64_t read_sequence() const { return read_sequence_; }  // of the last turn

  absl::StatusOr<std::optional<storage::LeasedSession>> Acquire(const storage::CallContext& context,
                                                                const std::string& owner,
                                                                std::chrono::milliseconds ttl) const override {
    ++looks_;
    return store_.Acquire(context, owner, ttl);
  }
  absl::Status Renew(const storage::CallContext& context, const storage::SessionLease& lease,
                     std::chrono::milliseconds ttl) const override {
    return store_.Renew(context, lease, ttl);
  }
  absl::Status Release(const storage::CallContext& context, const storage::SessionLease& lease,
                       std::int64_t read_sequence) const override {
    read_sequence_ = read_sequence;
    return store_.Release(context, lease, read_sequence);
  }
  absl::Status Queue(const storage::CallContext& context, const SiteId& site, const SessionId& session) const override {
    return store_.Queue(context, site, session);
  }
  absl::StatusOr<storage::MappingBacklog> GetBacklog(const storage::CallContext& context) const override {
    return store_.GetBacklog(context);
  }
  absl::StatusOr<std::int64_t> Commit(const storage::CallContext& context, const storage::SessionLease& lease,
                                      const storage::MappingStep& step) const override {
    ++commits_;
    return store_.Commit(context, lease, step);
  }
  absl::StatusOr<std::optional<storage::StoredMapping>> Load(const storage::CallContext& context, const SiteId& site,
                                                             const SessionId& session) const override {
    ++loads_;
    return store_.Load(context, site, session);
  }
  absl::StatusOr<storage::Trajectory> ReadTrajectory(const storage::CallContext& context, const SiteId& site,
                                                     const SessionId& session) const override {
    return store_.ReadTrajectory(context, site, session);
  }
  absl::StatusOr<std::vector<slam::SlamNode>> ListKeyframes(const storage::CallContext& context, const SiteId& site,
                                                            const SessionId& session) const override {
    return store_.ListKeyframes(context, site, session);
  }
  absl::StatusOr<std::optional<PoseWithCovariance>> FindKeyframe(const storage::CallContext& context,
                                                                 const SiteId& site, const SessionId& session,
                                                                 TimeNs time) const override {
    return store_.FindKeyframe(context, site, session, time);
  }

 private:
  const storage::MappingStore& store_;
  mutable std::atomic<int> looks_{0};
  mutable std::atomic<int> loads_{0};
  mutable std::atomic<int> commits_{0};
  mutable std::atomic<std::int64_t> read_sequence_{0};
};

// Throws or waits when the records of one session are read.
class FaultyRecordStore final : public storage::RecordStore {
 public:
  explicit FaultyRecordStore(const storage::RecordStore& store) : store_(store) {}

  void ThrowFor(const SessionId& session) { poison_ = session; }
  int throws() const { return throws_; }
  void HoldUp(const SessionId& session) { held_up_ = session; }
  void LetGo() { let_go_ = true; }
  bool is_waiting() const { return waiting_; }

  std::vector<absl::StatusOr<storage::AppendResult>> AppendGroup(
      const storage::CallContext& context, absl::Span<const storage::RecordBatch> batches) const override {
    return store_.AppendGroup(context, batches);
  }
  absl::StatusOr<std::vector<sensor::Record>> Read(const storage::CallContext& context, const SiteId& site,
                                                   const SessionId& session, std::int64_t from_sequence,
                                                   std::int64_t max_bytes) const override {
    if (session == poison_) {
      ++throws_;
      throw std::bad_alloc();
    }
    waiting_ = session == held_up_;
    while (waiting_ && !let_go_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
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

 private:
  const storage::RecordStore& store_;
  SessionId poison_{"none"};
  SessionId held_up_{"none"};
  std::atomic<bool> let_go_{false};
  mutable std::atomic<bool> waiting_{false};
  mutable std::atomic<int> throws_{0};
};

class MappingWorkersTest : public MappingFixture {
 protected:
  void Start(int workers = 1) {
    options_.workers = workers;
    SessionMappingStores stores{counting_,           records_,    stores_.sessions, stores_.blobs, stores_.revisions,
                                stores_.robot_poses, stores_.maps};
    mapping_.emplace(options_, slam::SlamOptions(), stores, *metrics_, [this] { ++ended_; });
  }
  // The first 40 records of a session that goes on are mapped and stored.
  SessionId StartWithLiveSession(double checkpoint_interval_s) {
    options_.checkpoint_interval_s = checkpoint_interval_s;
    const SessionId session = NewSession("s");
    Append(session, 0, 40);
    Start();
    AwaitMapped(session, 40);
    return session;
  }
  void AwaitState(const SessionId& session, storage::SessionState state) {
    while (Session(session).state != state) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  void AwaitMapped(const SessionId& session, std::int64_t sequence) {
    while (Session(session).mapped_sequence < sequence) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  void AwaitEnded(int count) {
    while (ended_ < count) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }

  ServerOptions::Mapping options_;
  CountingMappingStore counting_{stores_.mappings};
  FaultyRecordStore records_{stores_.records};
  const std::unique_ptr<Metrics> metrics_ = *Metrics::Create("");
  std::atomic<int> ended_{0};
  std::optional<Mapping> mapping_;
};

}  // namespace enfilade::server
