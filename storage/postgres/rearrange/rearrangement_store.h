// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/graph/rearrangement_store.h"
#include "storage/postgres/driver/pool.h"

namespace enfilade::storage::postgres {

class RearrangementStore final : public storage::RearrangementStore {
 public:
  explicit RearrangementStore(Pool& pool) : pool_(pool) {}

  absl::StatusOr<StoredRearrangement> Apply(const CallContext& context, const SiteLease& lease,
                                            const RearrangementChange& change) const override;
  absl::StatusOr<StoredRearrangement> Undo(const CallContext& context, const SiteLease& lease,
                                           const rearrange::RearrangementId& id) const override;
  absl::StatusOr<rearrange::MapRedirect> Resolve(const CallContext& context, const SiteId& site,
                                                 const MapId& map) const override;
  absl::StatusOr<StoredRearrangement> Get(const CallContext& context, const SiteId& site,
                                          const rearrange::RearrangementId& id) const override;
  absl::StatusOr<std::vector<StoredRearrangement>> List(const CallContext& context, const SiteId& site,
                                                        std::int64_t before, int limit) const override;

 private:
  Pool& pool_;
};

}  // namespace enfilade::storage::postgres
