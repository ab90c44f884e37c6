// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "absl/status/status.h"
#include "server/app/runtime/stop_signal.h"
#include "storage/call_context.h"
#include "storage/graph/site_lease_store.h"

namespace enfilade::server {

// What doors are judged under: the site's lease, renewed between comparisons, and the deadline of each store call. Not
// thread-safe.
class JudgingLease {
 public:
  using Clock = std::chrono::steady_clock;

  // All must outlive it. The lease has just been acquired. `now` is for tests.
  JudgingLease(const storage::SiteLeaseStore& leases, const storage::SiteLease& lease, const StopSignal& stop,
               Clock::time_point (*now)() = Clock::now)
      : leases_(leases), lease_(lease), stop_(stop), now_(now), renewed_(now()) {}

  const storage::SiteLease& lease() const { return lease_; }
  const SiteId& site() const { return lease_.site; }

  static constexpr std::chrono::seconds kTime{20};  // how long it holds without being renewed

  // For one store call that starts now.
  static storage::CallContext Context();
  // Renews the lease if a quarter of its time has passed: each time is a commit, and a report may be compared with
  // dozens of maps. CANCELLED if the server is stopping; ABORTED if another process has the lease; else the store's
  // errors. Who writes under the lease is told in any case if it is lost.
  absl::Status Renew() const;

 private:
  const storage::SiteLeaseStore& leases_;
  const storage::SiteLease& lease_;
  const StopSignal& stop_;
  Clock::time_point (*const now_)();
  mutable Clock::time_point renewed_;
};

}  // namespace enfilade::server
