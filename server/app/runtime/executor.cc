// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/executor.h"

#include <utility>

#include "server/app/runtime/thread_priority.h"

namespace enfilade::server {

Executor::Executor(int threads, std::size_t max_queued, int niceness) : max_queued_(max_queued), niceness_(niceness) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Run(); });
}

Executor::~Executor() { Stop(); }

void Executor::Stop() {
  {
    MutexLock lock(mutex_);
    stopping_ = true;
    changed_.NotifyAll();
  }
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

bool Executor::Post(std::function<void()> task) {
  {
    MutexLock lock(mutex_);
    if (tasks_.size() >= max_queued_) return false;
    tasks_.push_back(std::move(task));
  }
  changed_.NotifyOne();  // without the lock, which the woken thread takes first
  return true;
}

void Executor::PostNext(std::function<void()> task) {
  {
    MutexLock lock(mutex_);
    tasks_.push_back(std::move(task));
  }
  changed_.NotifyOne();
}

void Executor::Run() {
  SetThreadNiceness(niceness_);
  while (true) {
    std::function<void()> task;
    {
      MutexLock lock(mutex_);
      while (!stopping_ && tasks_.empty()) changed_.Wait(mutex_);
      if (tasks_.empty()) return;
      task = std::move(tasks_.front());
      tasks_.pop_front();
    }
    task();
  }
}

}  // namespace enfilade::server
