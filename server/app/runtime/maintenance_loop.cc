// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/maintenance_loop.h"

#include <utility>

#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

constexpr auto kPortionTimeout = std::chrono::seconds(30);
// After an outage, a robot may send the record that refers to a blob long after the blob.
constexpr auto kBlobGrace = std::chrono::hours(24);

}  // namespace

std::vector<MaintenanceJob> MaintenanceJobs(const storage::Maintenance& maintenance, std::chrono::seconds undo_kept) {
  return {
      {"rows of deleted sessions",
       [&maintenance](const storage::CallContext& context, std::int64_t limit) {
         return maintenance.PurgeDeletedSessions(context, limit);
       }},
      {"records past their retention",
       [&maintenance](const storage::CallContext& context, std::int64_t limit) {
         return maintenance.DeleteExpiredRecords(context, limit);
       }},
      {"rows of rearrangements that are too old to be undone",
       [&maintenance, undo_kept](const storage::CallContext& context, std::int64_t limit) {
         return maintenance.DeleteExpiredUndo(context, undo_kept, limit);
       }},
      {"unused blobs",
       [&maintenance](const storage::CallContext& context, std::int64_t limit) {
         return maintenance.CollectBlobs(context, kBlobGrace, limit);
       }},
  };
}

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
  std::int64_t deleted = 0;
  while (!stop_.is_set()) {
    const auto portion = job.delete_portion(storage::CallContext::WithTimeout(kPortionTimeout), kPortionRows);
    if (!portion.ok()) {
      spdlog::warn("maintenance: {}: {}", job.deletes, portion.status().ToString());
      break;
    }
    deleted += *portion;
    if (*portion < kPortionRows) break;
  }
  if (deleted > 0) spdlog::info("maintenance: deleted {} {}", deleted, job.deletes);
}

}  // namespace enfilade::server
