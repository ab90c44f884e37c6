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
#include "server/app/graph/pose_looks.h"
#include "server/app/runtime/executor.h"
#include "server/app/watch/site_moment.h"
#include "storage/sites/activity_store.h"

namespace enfilade::server {

// Looks at whole sites for all who watch them: one look serves all watchers of a site, and nothing is read of a site
// that nobody watches. Thread-safe.
class SiteLooks {
 public:
  struct Options {
    std::chrono::steady_clock::duration timeout = std::chrono::seconds(30);  // of one look
    // Sessions, rasters and health are read again after so long, however often poses and the graph are looked at.
    std::chrono::steady_clock::duration activity_interval = std::chrono::seconds(1);
    // How long what was seen of a site that nobody watches any more is kept, so that watchers who come back hear what
    // has changed and not everything.
    std::chrono::steady_clock::duration kept = std::chrono::minutes(10);
  };
  using Result = absl::StatusOr<std::shared_ptr<const SiteMoment>>;

  SiteLooks(PoseLooks& poses, const storage::ActivityStore& activity, const Options& options);
  // Calls Stop.
  ~SiteLooks();
  SiteLooks(const SiteLooks&) = delete;
  SiteLooks& operator=(const SiteLooks&) = delete;

  // As PoseLooks::Admit, whose watchers these are as well.
  absl::StatusOr<PoseLooks::Watcher> Admit(const SiteId& site) { return poses_.Admit(site); }

  // As PoseLooks::Look, with the whole site. The same pointer as last time if nothing has changed.
  void Look(const SiteId& site, std::function<void(const Result&)> then);

  // After the last Look has been answered.
  void Stop();

 private:
  using Waiter = std::function<void(const Result&)>;
  using Clock = std::chrono::steady_clock;
  struct Entry {
    std::shared_ptr<const SiteMoment> last;
    Clock::time_point activity_read = {};
    Clock::time_point looked = {};
    bool looking = false;
    std::vector<Waiter> waiters;
  };

  Result Read(const SiteId& site, std::shared_ptr<const SitePoses> poses);
  void Answer(const SiteId& site, const Result& look);
  void ForgetUnwatched(Clock::time_point now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  PoseLooks& poses_;
  const storage::ActivityStore& activity_;
  const Options options_;
  Mutex mutex_;
  std::unordered_map<SiteId, Entry> entries_ ABSL_GUARDED_BY(mutex_);
  Clock::time_point swept_ ABSL_GUARDED_BY(mutex_) = {};
  Executor readers_;
};

}  // namespace enfilade::server
