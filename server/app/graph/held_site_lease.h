// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "server/app/runtime/stop_signal.h"
#include "storage/graph/site_lease_store.h"

namespace enfilade::server {

// A site's lease that ends with its scope.
class HeldSiteLease {
 public:
  // Tries until the context's deadline. ABORTED: another process held the lease all the time; UNAVAILABLE: `stop`, if
  // it is not null, was set; CANCELLED: the context's cancellation was requested.
  static absl::StatusOr<HeldSiteLease> Await(const storage::SiteLeaseStore& leases, const storage::CallContext& context,
                                             const SiteId& site, const std::string& owner,
                                             std::chrono::milliseconds ttl, StopSignal* stop);

  HeldSiteLease(HeldSiteLease&& other) noexcept
      : leases_(std::exchange(other.leases_, nullptr)),
        context_(std::move(other.context_)),
        lease_(std::move(other.lease_)) {}
  HeldSiteLease& operator=(HeldSiteLease&&) = delete;
  ~HeldSiteLease();

  const storage::SiteLease& operator*() const { return lease_; }

 private:
  HeldSiteLease(const storage::SiteLeaseStore& leases, storage::CallContext context, storage::SiteLease lease)
      : leases_(&leases), context_(std::move(context)), lease_(std::move(lease)) {}

  const storage::SiteLeaseStore* leases_;  // null: moved from
  storage::CallContext context_;
  storage::SiteLease lease_;
};

}  // namespace enfilade::server
