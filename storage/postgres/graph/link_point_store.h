// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/graph/link_point_store.h"
#include "storage/postgres/driver/pool.h"

namespace enfilade::storage::postgres {

class LinkPointStore final : public storage::LinkPointStore {
 public:
  explicit LinkPointStore(Pool& pool) : pool_(pool) {}

  absl::StatusOr<StoredLinkPoint> Create(const CallContext& context, const StoredLinkPoint& link_point,
                                         const RequestId& request_id) const override;
  absl::StatusOr<StoredLinkPoint> AddAnchor(const CallContext& context, const SiteId& site,
                                            const NewAnchor& added) const override;
  absl::StatusOr<StoredLinkPoint> Get(const CallContext& context, const SiteId& site,
                                      const LinkPointId& id) const override;
  absl::StatusOr<std::vector<StoredLinkPoint>> List(const CallContext& context, const SiteId& site,
                                                    const LinkPointFilter& filter,
                                                    const PageRequest& page) const override;
  absl::StatusOr<StoredLinkPoint> Update(const CallContext& context, const StoredLinkPoint& link_point) const override;
  absl::StatusOr<StoredLinkPoint> SetSuspended(const CallContext& context, const SiteId& site, const LinkPointId& id,
                                               std::int64_t etag, bool suspended) const override;
  absl::Status Delete(const CallContext& context, const SiteId& site, const LinkPointId& id,
                      std::int64_t etag) const override;
  absl::StatusOr<ChangedLinkPoints> Change(const CallContext& context, const SiteId& site,
                                           const std::vector<LinkPointChange>& changes) const override;
  absl::StatusOr<FoundLinkPoints> Find(const CallContext& context, const SiteId& site,
                                       const LinkPointQuery& query) const override;
  absl::StatusOr<std::vector<StoredLinkPoint>> ListUnplaced(const CallContext& context, const SiteId& site,
                                                            int limit) const override;
  absl::Status PutEvidence(const CallContext& context, const SiteId& site, const Evidence& evidence) const override;
  absl::StatusOr<std::vector<Evidence>> ListEvidence(const CallContext& context, const SiteId& site,
                                                     const std::vector<LinkPointId>& link_points) const override;

 private:
  Pool& pool_;
};

}  // namespace enfilade::storage::postgres
