// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/maintenance_jobs.h"

#include <algorithm>
#include <functional>
#include <string>
#include <utility>

#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

using storage::CallContext;
using storage::Maintenance;
using storage::MaintenancePortion;

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

using Collection = std::function<absl::StatusOr<MaintenancePortion>(const CallContext& context, std::int64_t limit)>;

// A portion is full when it looked at many things, however few of them are deleted.
MaintenanceJob Collecting(std::string what, std::string deleted, Metrics& metrics, Collection collection) {
  return {std::move(what),
          [deleted = std::move(deleted), &metrics, collection = std::move(collection)](
              const CallContext& context, std::int64_t limit) -> absl::StatusOr<std::int64_t> {
            ENFILADE_ASSIGN_OR_RETURN(const MaintenancePortion portion, collection(context, limit));
            if (portion.deleted > 0) metrics.CountRowsDeleted(deleted, portion.deleted);
            return std::max(portion.looked_at, portion.deleted);
          },
          "looked at"};
}

}  // namespace

std::vector<MaintenanceJob> MaintenanceJobs(const MaintenanceStores& stores, const MaintenanceLimits& limits,
                                            Metrics& metrics) {
  const Maintenance& maintenance = stores.maintenance;
  std::vector<MaintenanceJob> jobs;
  if (limits.idle.count() > 0) jobs.push_back(Closing(stores.sessions, limits.idle, metrics));
  const auto deleting = [&](const std::string& what, auto deletion) {
    jobs.push_back(Deleting(what, metrics, [&maintenance, deletion](const CallContext& context, std::int64_t limit) {
      return (maintenance.*deletion)(context, limit);
    }));
  };
  deleting("sessions past their retention", &Maintenance::DeleteFinishedSessions);
  deleting("deleted sessions", &Maintenance::PurgeDeletedSessions);
  jobs.push_back(
      Deleting("forgotten sessions", metrics,
               [&maintenance, kept = limits.deleted_session](const CallContext& context, std::int64_t limit) {
                 return maintenance.ForgetDeletedSessions(context, kept, limit);
               }));
  deleting("expired records", &Maintenance::DeleteExpiredRecords);
  deleting("versions of graphs", &Maintenance::DeleteGraphHistory);
  deleting("audit entries", &Maintenance::DeleteAuditEntries);
  jobs.push_back(Deleting("expired undo", metrics,
                          [&maintenance, kept = limits.undo_kept](const CallContext& context, std::int64_t limit) {
                            return maintenance.DeleteExpiredUndo(context, kept, limit);
                          }));
  jobs.push_back(Collecting("maps with old revisions", "revisions", metrics,
                            [&maintenance](const CallContext& context, std::int64_t limit) {
                              return maintenance.DeleteRevisions(context, limit);
                            }));
  jobs.push_back(
      Collecting("blobs that may be unused", "unused blobs", metrics,
                 [&maintenance, unused = limits.unused_blob](const CallContext& context, std::int64_t limit) {
                   return maintenance.CollectBlobs(context, unused, limit);
                 }));
  return jobs;
}

}  // namespace enfilade::server
