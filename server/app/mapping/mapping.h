// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/app/mapping/session_mapping.h"
#include "server/app/runtime/metrics.h"
#include "server/app/runtime/stop_signal.h"
#include "server/config/server_options.h"
#include "storage/mapping_store.h"

namespace enfilade::server {

// Maps the sessions of all sites, whichever waits longest, each by one worker of one process at a time: a worker holds
// the session's lease, stores results and checkpoint together, and stops when the lease is lost. After a while the
// next session has its turn.
class Mapping {
 public:
  // `mapped` is called whenever a session has come to its end.
  Mapping(const ServerOptions::Mapping& options, const slam::SlamProfiles& slam, const SessionMappingStores& stores,
          Metrics& metrics, std::function<void()> mapped = {});
  // Stores what is mapped and gives the leases back.
  ~Mapping();
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  // New records may have come.
  void Wake();
  // Begins what the destructor waits for.
  void Stop();

 private:
  struct Turn;

  void Work(int worker);
  void KeepLeases();
  // False where there was nothing to do.
  bool TakeTurn(const std::string& owner);
  void MapSession(const storage::LeasedSession& leased, Turn& turn);
  absl::Status MapUntilTurnEnds(const storage::SessionLease& lease, SessionMapping& mapping, Turn& turn);
  void WaitForRecords();
  std::unique_ptr<SessionMapping> Unpark(const storage::LeasedSession& leased);
  void Park(const storage::SessionLease& lease, std::unique_ptr<SessionMapping> mapping);

  const ServerOptions::Mapping options_;
  const SessionMappingStores stores_;
  const SessionMappingOptions session_options_;
  Metrics& metrics_;
  const std::function<void()> mapped_;
  const std::string owner_;

  // A mapping that had its turn and may soon have another: spares reading all of it back from the database.
  struct Parked {
    storage::SessionLease lease;
    std::unique_ptr<SessionMapping> mapping;
  };

  StopSignal stop_;
  Mutex mutex_;
  CondVar changed_;  // woken_
  bool woken_ ABSL_GUARDED_BY(mutex_) = false;
  std::list<Parked> parked_ ABSL_GUARDED_BY(mutex_);  // the latest first
  std::list<std::shared_ptr<Turn>> turns_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::thread> workers_;
  StopSignal workers_done_;
  std::thread lease_keeper_;
};

}  // namespace enfilade::server
