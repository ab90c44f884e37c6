// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/maintenance_jobs.h"

#include <functional>
#include <string>
#include <utility>

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

using storage::CallContext;
using storage::Maintenance;

// After an outage, a robot may send the record that refers to a blob long after the blob.
constexpr auto kBlobGrace = std::chrono::hours(24);

using Deletion = std::function<absl::StatusOr<std::int64_t>(const CallContext& context, std::int64_t limit)>;

MaintenanceJob Deleting(std::string what, Metrics& metrics, Deletion deletion) {
  return {what,
          [what, &metrics, deletion = std::move(deletion)](const CallContext& context,
                                                           std::int64_t limit) -> absl::StatusOr<std::int64_t> {
            ENFILADE_ASSIGN_OR_RETURN(const std::int64_t deleted, deletion(context, limit));
            if (deleted > 0) metrics.CountRowsDeleted(what, deleted);
            return deleted;
          }};
}

MaintenanceJob Closing(const storage::SessionStore& sessions, std::chrono::seconds idle, Metrics& metrics) {
  return {"idle sessions",
          [&sessions, idle, &metrics](const CallContext& context, std::int64_t limit) -> absl::StatusOr<std::int64_t> {
            ENFILADE_ASSIGN_OR_RETURN(const storage::ClosedSessions closed, sessions.CloseIdle(context, idle, limit));
            metrics.CountIdleSessionsClosed(closed.finished, closed.failed);
            return closed.finished + closed.failed;
          },
          "closed"};
}

// A portion is full when it looked at many blobs, however few of them are unused.
MaintenanceJob Collecting(const Maintenance& maintenance, Metrics& metrics) {
  return {"blobs that may be unused",
          [&maintenance, &metrics](const CallContext& context, std::int64_t limit) -> absl::StatusOr<std::int64_t> {
            ENFILADE_ASSIGN_OR_RETURN(const storage::BlobCollection blobs,
                                      maintenance.CollectBlobs(context, kBlobGrace, limit));
            if (blobs.deleted > 0) metrics.CountRowsDeleted("unused blobs", blobs.deleted);
            return blobs.looked_at;
          },
          "looked at"};
}

}  // namespace

std::vector<MaintenanceJob> MaintenanceJobs(const MaintenanceStores& stores, const MaintenanceLimits& limits,
                                            Metrics& metrics) {
  const Maintenance& maintenance = stores.maintenance;
  std::vector<MaintenanceJob> jobs;
  if (limits.idle.count() > 0) jobs.push_back(Closing(stores.sessions, limits.idle, metrics));
  jobs.push_back(Deleting("deleted sessions", metrics, [&maintenance](const CallContext& context, std::int64_t limit) {
    return maintenance.PurgeDeletedSessions(context, limit);
  }));
  jobs.push_back(Deleting("expired records", metrics, [&maintenance](const CallContext& context, std::int64_t limit) {
    return maintenance.DeleteExpiredRecords(context, limit);
  }));
  jobs.push_back(Deleting("expired undo", metrics,
                          [&maintenance, kept = limits.undo_kept](const CallContext& context, std::int64_t limit) {
                            return maintenance.DeleteExpiredUndo(context, kept, limit);
                          }));
  jobs.push_back(Collecting(maintenance, metrics));
  return jobs;
}

}  // namespace enfilade::server
