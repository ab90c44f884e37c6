// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <unordered_map>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/mutex.h"
#include "server/app/graph/pose_updates.h"
#include "server/app/graph/site_graphs.h"
#include "server/app/runtime/executor.h"
#include "storage/graph/robot_pose_store.h"

namespace enfilade::server {

// Looks at the poses of sites' robots for all who watch them: one look serves all watchers of a site, however many
// there are. Thread-safe.
class PoseLooks {
 public:
  struct Options {
    int max_per_site = 1000;  // watchers
    int max_in_all = 4000;
    std::chrono::steady_clock::duration timeout = std::chrono::seconds(30);  // of one look
    // A look that is not older serves the next watcher as well.
    std::chrono::steady_clock::duration fresh = std::chrono::milliseconds(40);
  };
  using Result = absl::StatusOr<std::shared_ptr<const SitePoses>>;
  // While it lives, its holder counts as a watcher of its site. Outlived by the PoseLooks.
  using Watcher = std::shared_ptr<const void>;

  PoseLooks(SiteGraphs& graphs, const storage::RobotPoseStore& reports, const Options& options);
  // Calls Stop.
  ~PoseLooks();
  PoseLooks(const PoseLooks&) = delete;
  PoseLooks& operator=(const PoseLooks&) = delete;

  // RESOURCE_EXHAUSTED if there are too many watchers.
  absl::StatusOr<Watcher> Admit(const SiteId& site);

  // Of all sites.
  int watchers();

  // Calls `then`, which must not wait, with poses that are hardly older than this call, in this thread or later in
  // another. Never waits. Each answer of a site follows those before it (Following) while the site is watched.
  // NOT_FOUND if there is no such site; otherwise as SiteGraphs::Get.
  void Look(const SiteId& site, std::function<void(const Result&)> then);

  // After the last Look has been answered.
  void Stop();

 private:
  using Waiter = std::function<void(const Result&)>;
  struct Entry {
    int watchers = 0;
    std::shared_ptr<const SitePoses> last;
    std::chrono::steady_clock::time_point taken = {};
    bool looking = false;
    std::vector<Waiter> waiters;
  };

  void Leave(const SiteId& site);
  Result Read(const SiteId& site, const std::shared_ptr<const SitePoses>& before) const;
  void Answer(const SiteId& site, const Result& look);
  void DropUnused(const SiteId& site) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  SiteGraphs& graphs_;
  const storage::RobotPoseStore& reports_;
  const Options options_;
  Mutex mutex_;
  std::unordered_map<SiteId, Entry> entries_ ABSL_GUARDED_BY(mutex_);
  int watchers_ ABSL_GUARDED_BY(mutex_) = 0;
  Executor readers_;
};

}  // namespace enfilade::server
