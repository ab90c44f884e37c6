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

// A session's loop closures, as people see and undo them; MappingStore writes them. Thread-safe; errors common to all
// stores: see SiteStore.
class LoopClosureStore {
 public:
  explicit LoopClosureStore(postgres::Pool& pool) : pool_(pool) {}

  // By id, those behind `after` (-1: from the first). NOT_FOUND where the session is missing.
  absl::StatusOr<std::vector<slam::LoopClosure>> List(const CallContext& context, const SiteId& site,
                                                      const SessionId& session, std::int64_t after, int limit) const;
  // A suspended closure takes no part in the map; a resumed one is judged anew. The session is mapped again from its
  // checkpoint, whoever was at it: its lease is taken away, and a session that was mapped becomes finished until its
  // graph is solved. NOT_FOUND. Nothing happens where it is so already.
  absl::StatusOr<slam::LoopClosure> SetSuspended(const CallContext& context, const SiteId& site,
                                                 const SessionId& session, std::int64_t closure, bool suspended) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
