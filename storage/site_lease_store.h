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
namespace postgres {
class Pool;
}

// The right to judge a site's doors or to solve its graph: one holder at a time among all processes. Of two holders the
// one with the lower token has lost it; what it still writes under its lease is refused.
struct SiteLease {
  SiteId site;
  std::string owner;
  std::int64_t token = 0;
};

// Thread-safe; errors common to all stores: see SiteStore. Leases run on the database's clock.
class SiteLeaseStore {
 public:
  explicit SiteLeaseStore(postgres::Pool& pool) : pool_(pool) {}

  // Unset where another one holds it. NOT_FOUND where the site does not exist.
  absl::StatusOr<std::optional<SiteLease>> Acquire(const CallContext& context, const SiteId& site,
                                                   const std::string& owner, std::chrono::milliseconds ttl) const;
  // Holds for `ttl` from now. ABORTED where another holder has taken over.
  absl::Status Renew(const CallContext& context, const SiteLease& lease, std::chrono::milliseconds ttl) const;
  // Others may acquire at once. Releasing a lost lease is no error.
  absl::Status Release(const CallContext& context, const SiteLease& lease) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
