// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/held_site_lease.h"

#include <algorithm>
#include <thread>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

constexpr auto kLeasePollInterval = std::chrono::milliseconds(50);
// A call that has been given up still gives its lease back.
constexpr auto kReleaseTimeout = std::chrono::seconds(2);

}  // namespace

absl::StatusOr<HeldSiteLease> HeldSiteLease::Await(const storage::SiteLeaseStore& leases,
                                                   const storage::CallContext& context, const SiteId& site,
                                                   const std::string& owner, std::chrono::milliseconds ttl,
                                                   StopSignal* stop) {
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(auto lease, leases.Acquire(context, site, owner, ttl));
    if (lease) return HeldSiteLease(leases, context, *std::move(lease));
    if (std::chrono::steady_clock::now() + kLeasePollInterval >= context.deadline) {
      return Aborted("{} is being optimised, judged or rearranged by another process: try again", NameOf(site));
    }
    if (stop == nullptr) {
      std::this_thread::sleep_for(kLeasePollInterval);
    } else if (stop->WaitFor(kLeasePollInterval)) {
      return absl::UnavailableError("the server is shutting down: try again");
    }
  }
}

HeldSiteLease::~HeldSiteLease() {
  if (leases_ == nullptr) return;
  context_.cancellation = {};
  context_.deadline = std::max(context_.deadline, std::chrono::steady_clock::now() + kReleaseTimeout);
  (void)leases_->Release(context_, lease_);
}

}  // namespace enfilade::server
