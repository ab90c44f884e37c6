// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/graph/site_lease_store.h"
#include "storage/postgres/driver/pool.h"

namespace enfilade::storage::postgres {

class SiteLeaseStore final : public storage::SiteLeaseStore {
 public:
  SiteLeaseStore(Pool& pool, SiteRight right) : pool_(pool), right_(right) {}

  absl::StatusOr<std::optional<SiteLease>> Acquire(const CallContext& context, const SiteId& site,
                                                   const std::string& owner,
                                                   std::chrono::milliseconds ttl) const override;
  absl::Status Renew(const CallContext& context, const SiteLease& lease, std::chrono::milliseconds ttl) const override;
  absl::Status Release(const CallContext& context, const SiteLease& lease) const override;

 private:
  Pool& pool_;
  const SiteRight right_;
};

}  // namespace enfilade::storage::postgres
