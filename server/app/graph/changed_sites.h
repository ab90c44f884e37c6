// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "core/base/ids.h"
#include "core/base/mutex.h"

namespace enfilade::server {

// The set of sites whose graphs have changed since the last Take. Thread-safe.
class ChangedSites {
 public:
  void Add(const SiteId& site) {
    MutexLock lock(mutex_);
    sites_.insert(site);
  }
  // Returns the set and clears it.
  std::set<SiteId> Take() {
    MutexLock lock(mutex_);
    return std::exchange(sites_, {});
  }

 private:
  Mutex mutex_;
  std::set<SiteId> sites_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace enfilade::server
