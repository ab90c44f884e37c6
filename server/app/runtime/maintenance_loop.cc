// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/maintenance_loop.h"

#include <functional>

#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

constexpr auto kSweepTimeout = std::chrono::seconds(30);
constexpr auto kFiguresInterval = std::chrono::seconds(1);
// A robot may send a blob and come back with the record that refers to it only after an outage.
constexpr auto kBlobGrace = std::chrono::hours(24);
constexpr std::int64_t kRowsPerPortion = 5000;

}  // namespace

MaintenanceLoop::MaintenanceLoop(const ServerOptions::Retention& options, storage::postgres::Pool& pool,
                                 const Readiness& readiness, Metrics& metrics)
    : options_(options), pool_(pool), readiness_(readiness), metrics_(metrics), maintenance_(pool) {
  thread_ = std::thread([this] { Run(); });
}

MaintenanceLoop::~MaintenanceLoop() {
  stop_.Set();
  thread_.join();
}

void MaintenanceLoop::Run() {
  std::chrono::duration<double> since_clean_up{0.0};
  while (!stop_.WaitFor(kFiguresInterval)) {
    const storage::postgres::Pool::Stats stats = pool_.stats();
    metrics_.SetDatabaseConnections(stats.open, stats.busy, stats.waiting);
    since_clean_up += kFiguresInterval;
    if (since_clean_up.count() < options_.interval_s || !readiness_.state().ready) continue;
    since_clean_up = since_clean_up.zero();
    CleanUp();
  }
}

void MaintenanceLoop::CleanUp() {
  struct Job {
    const char* what;
    std::function<absl::StatusOr<std::int64_t>(const storage::CallContext&)> run;
  };
  const Job jobs[] = {
      {"rows of deleted sessions",
       [this](const storage::CallContext& context) {
         return maintenance_.PurgeDeletedSessions(context, kRowsPerPortion);
       }},
      {"records past their retention",
       [this](const storage::CallContext& context) {
         return maintenance_.DeleteExpiredRecords(context, kRowsPerPortion);
       }},
      {"unused blobs",
       [this](const storage::CallContext& context) {
         return maintenance_.CollectBlobs(context, kBlobGrace, kRowsPerPortion);
       }},
  };
  for (const Job& job : jobs) {
    std::int64_t deleted = 0;
    while (!stop_.is_set()) {
      const auto portion = job.run(storage::CallContext::WithTimeout(kSweepTimeout));
      if (!portion.ok()) {
        spdlog::warn("maintenance: {}: {}", job.what, portion.status().ToString());
        break;
      }
      deleted += *portion;
      if (*portion < kRowsPerPortion) break;
    }
    if (deleted > 0) spdlog::info("maintenance: deleted {} {}", deleted, job.what);
  }
}

}  // namespace enfilade::server
