// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "core/base/mutex.h"

namespace enfilade::server {

// Asks a periodic thread to stop. Thread-safe.
class StopSignal {
 public:
  void Set() {
    MutexLock lock(mutex_);
    set_ = true;
    changed_.NotifyAll();
  }
  bool is_set() const {
    MutexLock lock(mutex_);
    return set_;
  }
  // Waits until the signal is set, at most for `time`. Returns whether it is set.
  bool WaitFor(std::chrono::steady_clock::duration time) {
    const auto deadline = std::chrono::steady_clock::now() + time;
    MutexLock lock(mutex_);
    while (!set_ && changed_.WaitUntil(mutex_, deadline)) {
    }
    return set_;
  }

 private:
  mutable Mutex mutex_;
  CondVar changed_;
  bool set_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace enfilade::server
