// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/app/runtime/stop_signal.h"
#include "storage/schema.h"

namespace enfilade::server {

// Whether this server can take work: the database answers and its migrations are at this program's head. Looks every
// second.
class Readiness {
 public:
  struct State {
    bool ready = false;
    std::string reason;  // why not, for people
    storage::SchemaState schema;
  };

  // `on_change` is called with every change of `ready`, first from the constructor, then from the looking thread.
  Readiness(storage::postgres::Pool& pool, std::function<void(const State&)> on_change);
  ~Readiness();
  Readiness(const Readiness&) = delete;
  Readiness& operator=(const Readiness&) = delete;

  State state() const;
  // Not ready from now on, for good: the server is about to end.
  void Drain();

 private:
  void Look();
  void Run();

  storage::postgres::Pool& pool_;
  const std::function<void(const State&)> on_change_;
  mutable Mutex mutex_;
  State state_ ABSL_GUARDED_BY(mutex_);
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  StopSignal stop_;
  std::thread thread_;
};

}  // namespace enfilade::server
