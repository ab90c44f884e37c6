// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "core/closure/closure_options.h"
#include "server/app/closure/closure_stores.h"
#include "server/app/closure/judging_lease.h"
#include "server/app/closure/seen_grounds.h"
#include "server/app/graph/site_graphs.h"
#include "server/app/runtime/stop_signal.h"
#include "server/app/runtime/wake_signal.h"

namespace enfilade::server {

// Judges the door reports of all sites' sessions when they are mapped, and assigns the sessions that follow them their
// map. One process at a time does so for a site: it holds the site's lease. The result of a report is one transaction,
// so that a process that dies leaves nothing half done, and the next one continues from there.
class DoorClosures {
 public:
  struct Listeners {
    std::function<void()> entered;  // sessions have been assigned their map
    std::function<void()> judged;   // all doors of a session are judged
  };

  // `wake` wakes it when a session may have been mapped.
  DoorClosures(const closure::DoorClosureOptions& options, const DoorClosureStores& stores, SiteGraphs& graphs,
               WakeSignal& wake, Listeners listeners);
  ~DoorClosures();
  DoorClosures(const DoorClosures&) = delete;
  DoorClosures& operator=(const DoorClosures&) = delete;

  // Starts stopping; the destructor waits for it.
  void Stop();

 private:
  void Run();
  // False if there was nothing to do.
  bool JudgePending();
  // False if it is too early for a verdict: what may lie behind the door is still being mapped.
  absl::StatusOr<bool> Settle(const JudgingLease& lease, const SessionId& session);
  absl::StatusOr<bool> SettleReport(const JudgingLease& lease, const storage::Session& session,
                                    const storage::StoredDoorReport& report);
  absl::Status SettleWaiting(const JudgingLease& lease, const SessionId& previous);
  // What is not due yet. Forgets sessions that have not been pending for long.
  storage::PostponedDoors NotDue();
  void RetryLater(const storage::PendingDoors& pending, const absl::Status& status);
  void Postpone(const storage::PendingDoors& pending);
  // Since it was first too early for a verdict; 0 if it was not.
  double SecondsWaited(const storage::PendingDoors& pending) const;

  const closure::DoorClosureOptions options_;
  const DoorClosureStores stores_;
  SiteGraphs& graphs_;
  WakeSignal& wake_;
  const Listeners listeners_;
  SeenGrounds grounds_;  // of the worker's thread
  const std::string owner_;
  StopSignal stop_;

  // A session whose judging failed is retried after a delay that grows with each failure. Only the worker's thread uses
  // the delays.
  struct Delay {
    int failures = 0;
    std::chrono::steady_clock::time_point until;
    std::optional<std::chrono::steady_clock::time_point> waiting_since;  // first too early for a verdict
  };
  std::map<std::pair<SiteId, SessionId>, Delay> delays_;
  // Sites that another process judges are tried again after a moment. Of the worker's thread, too.
  std::map<SiteId, std::chrono::steady_clock::time_point> busy_until_;
  std::thread worker_;
};

}  // namespace enfilade::server
