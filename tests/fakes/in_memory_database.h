// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/call_context.h"
#include "storage/graph/graph_store.h"
#include "tests/fakes/in_memory_tables.h"

namespace enfilade::testing {

// What the in-memory stores share: they keep the contracts of storage/ without a database, for unit tests of what
// uses the stores (in_memory_stores.h). A call is atomic; writers of a graph follow one another, as with row locks.
// Thread-safe.
class InMemoryDatabase {
 public:
  // Rows that none of the in-memory stores writes.
  void AddSite(const SiteId& site);
  void AddRobot(const SiteId& site, const RobotId& robot);
  // Gives a session that waits at a passage its map, as judging the passage does.
  void EnterMap(const SiteId& site, const SessionId& session, const MapId& map, const PoseWithCovariance& T_map_robot);
  // Deletes a session's records, as Maintenance does past the site's retention.
  void ExpireRecords(const SiteId& site, const SessionId& session);
  // Makes a record's payload undecodable.
  void CorruptRecord(const SiteId& site, const SessionId& session, std::int64_t sequence);

  // Every call fails with `status` until it is OK again; listeners, too.
  void FailCalls(absl::Status status);
  // Lets leases expire without waiting.
  void AdvanceClock(std::chrono::milliseconds time);

  std::int64_t CountBlobs() const;
  std::int64_t CountRecords() const;
  std::int64_t CountRevisions() const;

  // For the stores. Exclusive access to all rows while it lives.
  class Access {
   public:
    Access(InMemoryDatabase& database, std::unique_lock<std::mutex> lock)
        : database_(&database), lock_(std::move(lock)) {}

    Tables& tables() { return database_->tables_; }
    // Null if it does not exist.
    SiteRows* FindSite(const SiteId& site);
    absl::StatusOr<SiteRows*> GetSite(const SiteId& site);                         // or NOT_FOUND
    absl::StatusOr<SessionRow*> GetSession(const SiteId& site, const SessionId&);  // also NOT_FOUND if deleted
    absl::StatusOr<MapRow*> GetMap(const SiteId& site, const MapId& map);
    absl::StatusOr<MapRow*> GetMapInUse(const SiteId& site, const MapId& map);  // also NOT_FOUND if redirected

    std::chrono::steady_clock::time_point Now() const;
    // Wall time; greater with every call.
    TimeNs Timestamp();
    std::int64_t NewEtag();
    // Makes the graph's next version and notifies the listeners.
    std::int64_t RaiseVersion(const SiteId& site, storage::GraphCause cause, const std::string& resource);
    // The site's graph becomes `before` again, which it was since this was opened; nobody hears of what was between.
    void RollBack(const SiteId& site, GraphRows before);

    void set_actor(const std::string& actor) { actor_ = actor; }

   private:
    InMemoryDatabase* database_;
    std::unique_lock<std::mutex> lock_;
    std::string actor_;
  };
  // DEADLINE_EXCEEDED if the deadline has passed; CANCELLED if the call is cancelled; the error of FailCalls.
  absl::StatusOr<Access> Open(const storage::CallContext& context);
  // Held by every writer of a graph until its call returns; taken before Open.
  std::unique_lock<std::mutex> LockGraphs() { return std::unique_lock(graph_writers_); }

  // The changes of graphs since the listener was opened.
  class Listener;
  absl::StatusOr<std::unique_ptr<storage::GraphListener>> Listen(const storage::CallContext& context);

 private:
  std::mutex graph_writers_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Tables tables_;
  std::vector<storage::GraphListener::Change> changes_;  // all of them
  absl::Status failure_;
  std::chrono::milliseconds clock_offset_{0};
  TimeNs last_timestamp_ = 0;
  std::int64_t last_etag_ = 0;
};

}  // namespace enfilade::testing
