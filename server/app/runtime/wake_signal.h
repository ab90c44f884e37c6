// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace enfilade::server {

// Wakes a polling thread before its next poll. A wake-up that comes while the thread is busy is not lost. Thread-safe.
class WakeSignal {
 public:
  void Wake() {
    MutexLock lock(mutex_);
    wake_requested_ = true;
    changed_.NotifyAll();
  }
  // Waits until Wake has been called since the last wait, at most for `time`.
  void WaitFor(std::chrono::steady_clock::duration time) {
    const auto deadline = std::chrono::steady_clock::now() + time;
    MutexLock lock(mutex_);
    while (!wake_requested_ && changed_.WaitUntil(mutex_, deadline)) {
    }
    wake_requested_ = false;
  }

 private:
  Mutex mutex_;
  CondVar changed_;
  bool wake_requested_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace enfilade::server
