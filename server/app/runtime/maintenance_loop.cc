// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/maintenance_loop.h"

#include <utility>

#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

constexpr auto kPortionTimeout = std::chrono::seconds(30);

}  // namespace

MaintenanceLoop::MaintenanceLoop(Options options, std::vector<MaintenanceJob> jobs)
    : options_(std::move(options)), jobs_(std::move(jobs)) {
  thread_ = std::thread([this] { Run(); });
}

MaintenanceLoop::~MaintenanceLoop() {
  stop_.Set();
  thread_.join();
}

void MaintenanceLoop::Run() {
  std::chrono::duration<double> since_last_round{0.0};
  while (!stop_.WaitFor(options_.tick)) {
    options_.on_tick();
    since_last_round += options_.tick;
    if (since_last_round < options_.interval || !options_.is_ready()) continue;
    since_last_round = since_last_round.zero();
    for (const MaintenanceJob& job : jobs_) RunJob(job);
  }
}

void MaintenanceLoop::RunJob(const MaintenanceJob& job) {
  std::int64_t done = 0;
  while (!stop_.is_set()) {
    const auto portion = job.do_portion(storage::CallContext::WithTimeout(kPortionTimeout), kPortionRows);
    if (!portion.ok()) {
      spdlog::warn("maintenance: {}: {}", job.what, portion.status().ToString());
      break;
    }
    done += *portion;
    if (*portion < kPortionRows) break;
  }
  if (done > 0) spdlog::info("maintenance: {} {} {}", job.verb, done, job.what);
}

}  // namespace enfilade::server
