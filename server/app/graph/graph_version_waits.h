// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>

#include "absl/status/status.h"
#include "core/base/ids.h"
#include "server/app/graph/site_graphs.h"

namespace enfilade::server {

// Lets calls wait until this process has read a version of a graph that another one has made: "read your writes" for
// clients of several servers. It asks the database at once, and again until the version is there. Thread-safe.
class GraphVersionWaits {
 public:
  // `max_wait`: of one call.
  GraphVersionWaits(SiteGraphs& graphs, std::chrono::steady_clock::duration max_wait);
  // Answers those who still wait.
  ~GraphVersionWaits();
  GraphVersionWaits(const GraphVersionWaits&) = delete;
  GraphVersionWaits& operator=(const GraphVersionWaits&) = delete;

  // Calls `then` when SiteGraphs answers from `version` or a later one, in this thread or in another; otherwise with
  // UNAVAILABLE after `max_wait` or at the deadline, NOT_FOUND if there is no such site, or RESOURCE_EXHAUSTED if too
  // many wait. Never waits itself; neither may `then`.
  void Await(const SiteId& site, std::int64_t version, std::chrono::steady_clock::time_point deadline,
             std::function<void(const absl::Status&)> then);

 private:
  struct Wait;
  class Waits;

  // Asks for the present version. SiteGraphs may answer after this object has gone.
  static void Ask(SiteGraphs& graphs, const std::shared_ptr<Waits>& waits, const std::shared_ptr<Wait>& wait);
  void Run();

  SiteGraphs& graphs_;
  const std::chrono::steady_clock::duration max_wait_;
  const std::shared_ptr<Waits> waits_;
  std::thread thread_;
};

}  // namespace enfilade::server
