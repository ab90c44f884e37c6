// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "server/app/runtime/stop_signal.h"
#include "storage/schema.h"

namespace enfilade::server {

// Whether this server can accept work: the database answers, and its schema is the one that this program was built for
// or a newer one that allows it. Checked periodically. Thread-safe.
class Readiness {
 public:
  struct State {
    bool ready = false;
    std::string reason;  // why it is not ready, for people
    storage::SchemaState schema;
    std::string detail;  // what the database says about it: for the log, not for callers
  };
  // Reads the schema's state from the database.
  using CheckSchema = std::function<absl::StatusOr<storage::SchemaState>()>;

  // Checks once before it returns. `on_change` is called with the first state, from the constructor, and then whenever
  // `ready` changes, from the checking thread or from Drain.
  Readiness(CheckSchema check_schema, std::function<void(const State&)> on_change,
            std::chrono::milliseconds interval = std::chrono::seconds(1));
  ~Readiness();
  Readiness(const Readiness&) = delete;
  Readiness& operator=(const Readiness&) = delete;

  State state() const;
  // Permanently not ready: the server is shutting down.
  void Drain();

 private:
  void Check();
  void Run();

  const CheckSchema check_schema_;
  const std::function<void(const State&)> on_change_;
  const std::chrono::milliseconds interval_;
  mutable Mutex mutex_;
  State state_ ABSL_GUARDED_BY(mutex_);
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  StopSignal stop_;
  std::thread thread_;
};

}  // namespace enfilade::server
