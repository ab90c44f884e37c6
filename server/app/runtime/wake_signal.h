// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace enfilade::server {

// Tells a thread that there may be work before its next look around. Thread-safe.
class WakeSignal {
 public:
  void Wake() {
    MutexLock lock(mutex_);
    woken_ = true;
    changed_.NotifyAll();
  }
  // Until woken, or for `time` at most.
  void WaitFor(std::chrono::steady_clock::duration time) {
    const auto deadline = std::chrono::steady_clock::now() + time;
    MutexLock lock(mutex_);
    while (!woken_ && changed_.WaitUntil(mutex_, deadline)) {
    }
    woken_ = false;
  }

 private:
  Mutex mutex_;
  CondVar changed_;
  bool woken_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace enfilade::server
