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

// A fixed number of threads for work that waits (the database, files), so that gRPC's own threads never do. The queue
// is bounded: a server that cannot keep up says so instead of growing.
class Executor {
 public:
  Executor(int threads, std::size_t max_queued);
  // Stops.
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  // Runs what is queued and waits until that is done; nothing may be posted any more. May be repeated.
  void Stop();

  // False, and the task is not run, where the queue is full.
  [[nodiscard]] bool Post(std::function<void()> task);
  // Queues also beyond the bound: for the next step of a call that has already begun.
  void PostNext(std::function<void()> task);

 private:
  void Run();

  const std::size_t max_queued_;
  Mutex mutex_;
  CondVar changed_;
  std::deque<std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace enfilade::server
