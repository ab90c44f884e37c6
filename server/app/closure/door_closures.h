// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "core/closure/closure_options.h"
#include "server/app/closure/closure_stores.h"
#include "server/app/graph/site_graphs.h"
#include "server/app/runtime/stop_signal.h"
#include "server/app/runtime/wake_signal.h"

namespace enfilade::server {

// Judges the door reports of all sites' sessions when they are mapped, and gives the sessions that come out of them
// their map. One process at a time does so for a site: it holds the site's lease. What a report comes to is one
// transaction, so that whoever dies leaves nothing half, and the next one goes on where it was.
class DoorClosures {
 public:
  // `wake`: when a session may have been mapped. `entered` is called when sessions have been given their map.
  DoorClosures(const closure::DoorClosureOptions& options, const DoorClosureStores& stores, SiteGraphs& graphs,
               WakeSignal& wake, std::function<void()> entered);
  ~DoorClosures();
  DoorClosures(const DoorClosures&) = delete;
  DoorClosures& operator=(const DoorClosures&) = delete;

  // Begins what the destructor waits for.
  void Stop();

 private:
  void Run();
  // False where there was nothing to do.
  bool TakeTurn();
  // False where it is too early to say: others are in the middle of mapping what may be behind the door.
  absl::StatusOr<bool> Settle(const storage::SiteLease& lease, const SessionId& session);
  absl::StatusOr<bool> SettleReport(const storage::SiteLease& lease, const storage::Session& session,
                                    const storage::StoredDoorReport& report);
  absl::Status SettleWaiting(const storage::SiteLease& lease, const SessionId& previous);
  bool MayTry(const storage::PendingDoors& pending);
  void Failed(const storage::PendingDoors& pending, const absl::Status& status);
  void Postpone(const storage::PendingDoors& pending);
  // s, since it was too early for the first time; 0 where it was not.
  double WaitedFor(const storage::PendingDoors& pending) const;

  const closure::DoorClosureOptions options_;
  const DoorClosureStores stores_;
  SiteGraphs& graphs_;
  WakeSignal& wake_;
  const std::function<void()> entered_;
  const std::string owner_;
  StopSignal stop_;

  // A session that failed waits before it is tried again, the longer the more often it did; the worker's own.
  struct Delay {
    int failures = 0;
    std::chrono::steady_clock::time_point until;
    std::optional<std::chrono::steady_clock::time_point> early_since;  // since it was too early for a verdict
  };
  std::map<std::string, Delay> delays_;  // by "site/session"
  bool site_busy_ = false;               // the worker's own, too: a site had to be left for later
  std::thread worker_;
};

}  // namespace enfilade::server
