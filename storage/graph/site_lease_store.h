// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "storage/call_context.h"

namespace enfilade::storage {

// A right on a site: one holder at a time among all processes. The token grows with every holder and fences the earlier
// ones: what they write under their lease is refused.
struct SiteLease {
  SiteId site;
  std::string owner;
  std::int64_t token = 0;
};

// What one process at a time does with a site. Each has its own leases.
enum class SiteRight {
  kChange,  // judge doors, rearrange maps, store a solution of the graph
  kSolve,   // compute a solution of the graph
};

// The leases on one right. They expire by the database's clock. Thread-safe; errors common to all stores: see
// SiteStore.
class SiteLeaseStore {
 public:
  virtual ~SiteLeaseStore() = default;

  // Unset if it is held, also by the same owner. NOT_FOUND if the site does not exist.
  virtual absl::StatusOr<std::optional<SiteLease>> Acquire(const CallContext& context, const SiteId& site,
                                                           const std::string& owner,
                                                           std::chrono::milliseconds ttl) const = 0;
  // Extends the lease to `ttl` from now. ABORTED if another holder has taken over.
  virtual absl::Status Renew(const CallContext& context, const SiteLease& lease,
                             std::chrono::milliseconds ttl) const = 0;
  // Makes the lease available. Releasing a lost lease is no error.
  virtual absl::Status Release(const CallContext& context, const SiteLease& lease) const = 0;
};

}  // namespace enfilade::storage
