// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "client/sdk/connection.h"
#include "core/base/ids.h"
#include "core/base/mutex.h"
#include "grpcpp/client_context.h"

namespace enfilade::bench {

// Those who look at a fleet while it drives, until Stop: dashboards that watch global poses, programs that export a map
// a second each, and one that calls GetSite 20 times a second and so notices what everybody else has to wait for.
class FleetReaders {
 public:
  struct Counts {
    std::int64_t pose_messages = 0;
    std::int64_t exports = 0;
    std::int64_t exported_bytes = 0;
    std::map<std::string, int> failed_exports;  // by the error
    std::int64_t failed_calls = 0;              // of GetSite
    std::vector<double> get_site_ms;
    std::vector<std::string> errors;  // of watches that ended before Stop
  };

  FleetReaders(const client::Connection& connection, std::vector<SiteId> sites, int watchers, int exporters,
               std::filesystem::path folder);
  ~FleetReaders();
  FleetReaders(const FleetReaders&) = delete;
  FleetReaders& operator=(const FleetReaders&) = delete;

  Counts Stop();

 private:
  void Watch(const SiteId& site, grpc::ClientContext& context);
  void Export(std::size_t first_site, const std::filesystem::path& folder);
  void Probe();

  const client::Connection connection_;
  const std::vector<SiteId> sites_;
  const std::filesystem::path folder_;
  std::atomic<bool> stop_ = false;
  Mutex mutex_;
  Counts counts_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::unique_ptr<grpc::ClientContext>> watches_;
  std::vector<std::thread> threads_;
};

}  // namespace enfilade::bench
