// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/app/mapping/parked_mappings.h"
#include "server/app/mapping/session_mapping.h"
#include "server/app/runtime/metrics.h"
#include "server/app/runtime/stop_signal.h"
#include "server/app/runtime/wake_signal.h"
#include "server/config/server_options.h"
#include "storage/sessions/mapping_store.h"

namespace enfilade::server {

// Maps the sessions of all sites. Each worker repeatedly takes the session that has waited longest, maps it for one
// turn of a few seconds, and releases it. A worker holds the session's lease, so that only one worker of one process
// maps it; it stores results and checkpoint together, and stops when the lease is lost.
//
// An exception (out of memory) ends the turn, not the process. A session whose turns end in this way, or with the death
// of their process, kMaxAttempts times in succession has failed. Thread-safe.
class Mapping {
 public:
  static constexpr std::int64_t kMaxAttempts = 10;

  // `on_session_ended` is called whenever a session is mapped or has failed.
  Mapping(const ServerOptions::Mapping& options, const slam::SlamProfiles& slam, const SessionMappingStores& stores,
          Metrics& metrics, std::function<void()> on_session_ended = {});
  // Stores the checkpoints and releases the leases.
  ~Mapping();
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  // Call when new records of the session may have arrived, or it may have finished. Any number of calls costs one look
  // for work, and none while a worker is mapping the session: that worker looks again after its turn.
  void Wake(const SiteId& site, const SessionId& session);
  // The same for sessions unknown.
  void Wake();
  // Asks the workers to stop, without waiting; the destructor waits.
  void Stop();

 private:
  struct Turn;

  void Work(int worker);
  void KeepLeases();
  void RenewLeases();
  void ReportBacklog();
  // Returns false if there was nothing to do.
  bool TakeTurn(const std::string& owner);
  void MapSession(const storage::LeasedSession& leased, Turn& turn);
  absl::Status MapForOneTurn(const storage::LeasedSession& leased, Turn& turn,
                             std::unique_ptr<SessionMapping>& mapping);
  // `was_parked`: it was kept since its last turn, and probably will be until its next one.
  absl::Status MapUntilTurnEnds(const storage::LeasedSession& leased, SessionMapping& mapping, Turn& turn,
                                bool was_parked);
  // Has sessions found again whose last results are not stored.
  void Queue(const storage::CallContext& context, const std::vector<storage::SessionLease>& leases) const;

  const ServerOptions::Mapping options_;
  const SessionMappingStores stores_;
  const SessionMappingOptions session_options_;
  Metrics& metrics_;
  const std::function<void()> on_session_ended_;
  const std::string owner_;

  StopSignal stop_;
  WakeSignal wake_;
  ParkedMappings parked_;
  Mutex mutex_;
  std::list<std::shared_ptr<Turn>> turns_ ABSL_GUARDED_BY(mutex_);
  std::set<std::pair<SiteId, SessionId>> woken_ ABSL_GUARDED_BY(mutex_);  // since the last look for work
  std::vector<std::thread> workers_;
  StopSignal workers_done_;
  std::thread lease_keeper_;
};

}  // namespace enfilade::server
