// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "server/app/runtime/stop_signal.h"
#include "storage/call_context.h"

namespace enfilade::server {

// One kind of clean-up, done in portions so that no transaction is long.
struct MaintenanceJob {
  std::string what;  // for the log: "unused blobs"
  // Deletes (or closes) at most `limit` of it and returns how many.
  std::function<absl::StatusOr<std::int64_t>(const storage::CallContext& context, std::int64_t limit)> do_portion;
  const char* verb = "deleted";  // for the log
};

// Runs jobs periodically on a thread of its own: each until a portion is not full. A job that fails is logged and tried
// again in the next round.
class MaintenanceLoop {
 public:
  static constexpr std::int64_t kPortionRows = 5000;

  // `is_ready`: rounds are skipped while it returns false. `on_tick` is called every `tick`.
  struct Options {
    std::chrono::duration<double> interval{300.0};
    std::chrono::milliseconds tick{1000};
    std::function<bool()> is_ready;
    std::function<void()> on_tick;
  };

  MaintenanceLoop(Options options, std::vector<MaintenanceJob> jobs);
  // Waits for the portion at work.
  ~MaintenanceLoop();
  MaintenanceLoop(const MaintenanceLoop&) = delete;
  MaintenanceLoop& operator=(const MaintenanceLoop&) = delete;

 private:
  void Run();
  void RunJob(const MaintenanceJob& job);

  const Options options_;
  const std::vector<MaintenanceJob> jobs_;
  StopSignal stop_;
  std::thread thread_;
};

}  // namespace enfilade::server
