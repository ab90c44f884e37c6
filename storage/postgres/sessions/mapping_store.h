// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/postgres/driver/pool.h"
#include "storage/sessions/mapping_store.h"

namespace enfilade::storage::postgres {

class MappingStore final : public storage::MappingStore {
 public:
  explicit MappingStore(Pool& pool) : pool_(pool) {}

  absl::StatusOr<std::optional<LeasedSession>> Acquire(const CallContext& context, const std::string& owner,
                                                       std::chrono::milliseconds ttl) const override;
  absl::Status Renew(const CallContext& context, const SessionLease& lease,
                     std::chrono::milliseconds ttl) const override;
  absl::Status Release(const CallContext& context, const SessionLease& lease,
                       std::int64_t read_sequence) const override;
  absl::Status Queue(const CallContext& context, const SiteId& site, const SessionId& session) const override;
  absl::StatusOr<MappingBacklog> GetBacklog(const CallContext& context) const override;
  absl::StatusOr<std::int64_t> Commit(const CallContext& context, const SessionLease& lease,
                                      const MappingStep& step) const override;
  absl::StatusOr<std::optional<StoredMapping>> Load(const CallContext& context, const SiteId& site,
                                                    const SessionId& session) const override;
  absl::StatusOr<Trajectory> ReadTrajectory(const CallContext& context, const SiteId& site,
                                            const SessionId& session) const override;
  absl::StatusOr<std::vector<slam::SlamNode>> ListKeyframes(const CallContext& context, const SiteId& site,
                                                            const SessionId& session) const override;
  absl::StatusOr<std::optional<PoseWithCovariance>> FindKeyframe(const CallContext& context, const SiteId& site,
                                                                 const SessionId& session, TimeNs time) const override;

 private:
  Pool& pool_;
};

}  // namespace enfilade::storage::postgres
