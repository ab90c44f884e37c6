// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>

#include "absl/status/statusor.h"
#include "storage/postgres/driver/pool.h"
#include "storage/sessions/session_store.h"

namespace enfilade::storage::postgres {

// SessionStore::CloseIdle.
absl::StatusOr<ClosedSessions> CloseIdleSessions(Pool& pool, const CallContext& context, std::chrono::seconds idle,
                                                 std::int64_t limit);

}  // namespace enfilade::storage::postgres
