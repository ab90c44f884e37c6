// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/app/mapping/session_mapping.h"
#include "storage/sessions/mapping_store.h"

namespace enfilade::server {

// The mappings of live sessions between two turns, kept to avoid loading them from the database again, and storing them
// in each turn. Thread-safe.
class ParkedMappings {
 public:
  // Keeps those that were parked last, up to this size; the last one in any case.
  explicit ParkedMappings(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  // Returns the sessions that there is no room for any more and whose last results are not stored.
  std::vector<storage::SessionLease> Park(const storage::SessionLease& lease, std::unique_ptr<SessionMapping> mapping);
  // The session's mapping; null if it is not kept, or another worker has had the session since it was parked.
  std::unique_ptr<SessionMapping> Take(const storage::LeasedSession& leased);

  // The sessions whose last results are not stored, if `which` chooses their mapping. Each is returned once only until
  // it is parked again.
  std::vector<storage::SessionLease> ListUnstored(const std::function<bool(const SessionMapping&)>& which);

 private:
  struct Parked {
    storage::SessionLease lease;
    std::unique_ptr<SessionMapping> mapping;
    std::size_t bytes = 0;
    bool listed = false;
  };

  // Prefers those that are stored, then those parked first.
  std::list<Parked>::iterator NextToEvict() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::size_t max_bytes_;
  Mutex mutex_;
  std::list<Parked> parked_ ABSL_GUARDED_BY(mutex_);  // most recent first
  std::size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace enfilade::server
