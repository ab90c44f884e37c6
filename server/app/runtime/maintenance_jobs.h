// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <vector>

#include "server/app/runtime/maintenance_loop.h"
#include "server/app/runtime/metrics.h"
#include "storage/sessions/session_store.h"
#include "storage/sites/maintenance.h"

namespace enfilade::server {

struct MaintenanceStores {
  const storage::Maintenance& maintenance;
  const storage::SessionStore& sessions;
};

struct MaintenanceLimits {
  std::chrono::seconds undo_kept{0};        // what undoing a rearrangement needs is deleted after that
  std::chrono::seconds idle{0};             // a session that got no record for so long is closed; 0: never
  std::chrono::seconds deleted_session{0};  // what is left of a deleted session is deleted after that
  std::chrono::seconds unused_blob{0};      // a blob that nothing refers to is deleted after that
};

// What is past its retention, sessions that nobody finishes, and what nothing refers to any more. The metrics count
// what they do. The stores and `metrics` must outlive the jobs.
std::vector<MaintenanceJob> MaintenanceJobs(const MaintenanceStores& stores, const MaintenanceLimits& limits,
                                            Metrics& metrics);

}  // namespace enfilade::server
