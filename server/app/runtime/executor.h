// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace enfilade::server {

// A fixed number of threads for blocking work (the database, files), so that gRPC's own threads never block. The queue
// is bounded: an overloaded server refuses work instead of growing. Thread-safe.
class Executor {
 public:
  // `niceness`: of the threads, 0 to 19. For work that must leave the processors to others.
  Executor(int threads, std::size_t max_queued, int niceness = 0);
  // Calls Stop.
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  // Waits until all queued tasks have run. Nothing may be posted after it returns; repeated calls are no-ops.
  void Stop();

  // Returns false, and drops the task, if the queue is full.
  [[nodiscard]] bool Post(std::function<void()> task);
  // Queues the task even if the queue is full: for the next step of a call that has been accepted.
  void PostNext(std::function<void()> task);

 private:
  void Run();

  const std::size_t max_queued_;
  const int niceness_;
  Mutex mutex_;
  CondVar changed_;
  std::deque<std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace enfilade::server
