// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/slam/slam_map.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// A session's loop closures, for people to list and suspend; MappingStore writes them. Thread-safe; errors common to
// all stores: see SiteStore.
class LoopClosureStore {
 public:
  explicit LoopClosureStore(postgres::Pool& pool) : pool_(pool) {}

  // By id, those after `after` (-1: from the first). NOT_FOUND if the session does not exist.
  absl::StatusOr<std::vector<slam::LoopClosure>> List(const CallContext& context, const SiteId& site,
                                                      const SessionId& session, std::int64_t after, int limit) const;
  // A suspended closure takes no part in the map; a resumed one is judged again. Revokes the session's lease, so that
  // it is mapped again from its checkpoint; a session that was mapped becomes finished until its graph is solved.
  // NOT_FOUND. No-op if already in that state.
  absl::StatusOr<slam::LoopClosure> SetSuspended(const CallContext& context, const SiteId& site,
                                                 const SessionId& session, std::int64_t closure, bool suspended) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
