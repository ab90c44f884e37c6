// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "absl/status/status.h"
#include "server/app/runtime/stop_signal.h"
#include "storage/call_context.h"
#include "storage/graph/site_lease_store.h"

namespace enfilade::server {

// What doors are judged under: the site's lease, renewed between comparisons, and the deadline of each store call.
class JudgingLease {
 public:
  // All must outlive it.
  JudgingLease(const storage::SiteLeaseStore& leases, const storage::SiteLease& lease, const StopSignal& stop)
      : leases_(leases), lease_(lease), stop_(stop) {}

  const storage::SiteLease& lease() const { return lease_; }
  const SiteId& site() const { return lease_.site; }

  static constexpr std::chrono::seconds kTime{20};  // how long it holds without being renewed

  // For one store call that starts now.
  static storage::CallContext Context();
  // CANCELLED if the server is stopping; ABORTED if another process has the lease; else the store's errors.
  absl::Status Renew() const;

 private:
  const storage::SiteLeaseStore& leases_;
  const storage::SiteLease& lease_;
  const StopSignal& stop_;
};

}  // namespace enfilade::server
