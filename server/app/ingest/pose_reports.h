// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "core/base/ids.h"
#include "core/base/mutex.h"
#include "server/app/runtime/executor.h"
#include "storage/graph/robot_pose_store.h"

namespace enfilade::server {

// Stores the poses that robots report: what comes within a short time, from whatever robots, is stored together, by
// site. One site's reports are stored one batch after the other; sites do not wait for one another. Bounded.
// Thread-safe.
class PoseReports {
 public:
  struct Options {
    std::chrono::steady_clock::duration timeout = std::chrono::seconds(30);  // of storing a batch
    std::chrono::steady_clock::duration gather = std::chrono::milliseconds(100);
    std::size_t max_batch = 2000;     // reports in a batch
    std::size_t max_waiting = 20000;  // reports of all sites
  };
  // Gets what became of a report, once; must not wait.
  using Answer = std::function<void(const absl::Status&)>;

  PoseReports(const storage::RobotPoseStore& store, const Options& options);
  // Calls Stop.
  ~PoseReports();
  PoseReports(const PoseReports&) = delete;
  PoseReports& operator=(const PoseReports&) = delete;

  // Answers when the report is stored, or with the reason why it is not: as from RobotPoseStore::ReportAll, or
  // RESOURCE_EXHAUSTED if too many wait, or UNAVAILABLE after Stop. Never waits. A batch is stored in the name of
  // `actor` if all its reports are; otherwise in no name.
  void Report(storage::RobotPose pose, std::string actor, Answer answer);

  // Stores what waits. Repeated calls are no-ops.
  void Stop();

 private:
  struct Waiting {
    storage::RobotPose pose;
    std::string actor;
    Answer answer;
  };
  struct SiteReports {
    std::deque<Waiting> waiting;
    bool storing = false;
  };

  // Until Stop: starts a batch for each site that has reports, once in a while.
  void Gather();
  void StartBatches() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Store(const SiteId& site, const std::vector<Waiting>& batch);

  const storage::RobotPoseStore& store_;
  const Options options_;
  Mutex mutex_;
  CondVar changed_;
  std::map<SiteId, SiteReports> sites_ ABSL_GUARDED_BY(mutex_);  // that have reports waiting or being stored
  std::size_t waiting_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  Executor writers_;
  std::thread gatherer_;
};

}  // namespace enfilade::server
