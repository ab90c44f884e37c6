// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <thread>

#include "server/app/runtime/metrics.h"
#include "server/app/runtime/readiness.h"
#include "server/app/runtime/stop_signal.h"
#include "server/config/server_options.h"
#include "storage/maintenance.h"
#include "storage/postgres/driver/pool.h"

namespace enfilade::server {

// Every now and then: deletes records past their site's retention, rows of deleted sessions and blobs that nothing
// refers to, in small portions, and brings the pool's figures up to date. Does nothing while the server is not ready.
class MaintenanceLoop {
 public:
  MaintenanceLoop(const ServerOptions::Retention& options, storage::postgres::Pool& pool, const Readiness& readiness,
                  Metrics& metrics);
  ~MaintenanceLoop();
  MaintenanceLoop(const MaintenanceLoop&) = delete;
  MaintenanceLoop& operator=(const MaintenanceLoop&) = delete;

 private:
  void Run();
  void CleanUp();

  const ServerOptions::Retention options_;
  storage::postgres::Pool& pool_;
  const Readiness& readiness_;
  Metrics& metrics_;
  const storage::Maintenance maintenance_;
  StopSignal stop_;
  std::thread thread_;
};

}  // namespace enfilade::server
