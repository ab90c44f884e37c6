// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "storage/postgres/driver/pool.h"
#include "storage/sessions/session_store.h"

namespace enfilade::storage::postgres {

class SessionStore final : public storage::SessionStore {
 public:
  explicit SessionStore(Pool& pool) : pool_(pool) {}

  absl::StatusOr<Session> Create(const CallContext& context, const Session& session,
                                 const RequestId& request_id) const override;
  absl::StatusOr<Session> Get(const CallContext& context, const SiteId& site, const SessionId& session) const override;
  absl::StatusOr<std::vector<Session>> List(const CallContext& context, const SiteId& site, const SessionFilter& filter,
                                            int limit, const std::optional<SessionPosition>& after) const override;
  absl::StatusOr<Session> Finish(const CallContext& context, const SiteId& site, const SessionId& session,
                                 std::int64_t last_sequence) const override;
  absl::StatusOr<ClosedSessions> CloseIdle(const CallContext& context, std::chrono::seconds idle,
                                           std::int64_t limit) const override;
  absl::Status Delete(const CallContext& context, const SiteId& site, const SessionId& session) const override;

 private:
  Pool& pool_;
};

}  // namespace enfilade::storage::postgres
