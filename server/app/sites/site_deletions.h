// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string_view>
#include <thread>
#include <unordered_set>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/mutex.h"
#include "server/app/runtime/metrics.h"
#include "server/app/runtime/stop_signal.h"
#include "server/app/runtime/wake_signal.h"
#include "storage/call_context.h"
#include "storage/sites/site_deletion.h"
#include "storage/sites/site_store.h"

namespace enfilade::server {

// Deletes sites in the background, on a thread of its own, in portions, and knows which sites are being deleted, by
// whichever replica: from about a second after it began. A deletion continues after every kind of restart. Thread-safe.
class SiteDeletions {
 public:
  static constexpr std::int64_t kPortionRows = 5000;

  struct Options {
    std::chrono::milliseconds interval{1000};  // between two looks for deleted sites
    std::function<bool()> is_ready;            // nothing is done while it returns false
    // Called when this replica comes to know that a site is being deleted.
    std::function<void(const SiteId&)> forget;
  };

  // What it refers to must outlive it.
  SiteDeletions(Options options, const storage::SiteStore& sites, const storage::SiteDeletion& deletion,
                Metrics& metrics);
  // Waits for the portion at work.
  ~SiteDeletions();
  SiteDeletions(const SiteDeletions&) = delete;
  SiteDeletions& operator=(const SiteDeletions&) = delete;

  // Begins to delete a site: SiteStore::Delete.
  absl::StatusOr<storage::Site> Begin(const storage::CallContext& context, const SiteId& site, std::int64_t etag,
                                      bool force);
  // Whether the site, by its id, is being deleted. Costs next to nothing while none is.
  bool IsBeingDeleted(std::string_view site) const;

  // Asks the thread to stop, without waiting.
  void Stop();

 private:
  void Run();
  // One portion of each site. Returns false if there was nothing to do.
  bool DeletePortions(const std::vector<storage::DeletedSite>& sites);
  void SetDeleted(const std::vector<storage::DeletedSite>& sites);
  void Add(const SiteId& site);

  const Options options_;
  const storage::SiteStore& sites_;
  const storage::SiteDeletion& deletion_;
  Metrics& metrics_;
  StopSignal stop_;
  WakeSignal wake_;
  std::atomic<bool> any_ = false;
  mutable Mutex mutex_;
  std::unordered_set<std::string> deleted_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace enfilade::server
