// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <stop_token>
#include <thread>
#include <unordered_map>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/mutex.h"
#include "server/app/graph/changed_sites.h"
#include "server/app/graph/site_graph.h"
#include "server/app/runtime/executor.h"
#include "server/app/runtime/stop_signal.h"
#include "storage/call_context.h"
#include "storage/graph/graph_store.h"

namespace enfilade::server {

// The sites' graphs, each cached from its first use. The store notifies a thread of changed graphs (GraphListener),
// whose changes are then read; meanwhile readers get the version before and do not wait. Every second the thread looks
// for changes whose notifications were lost. While the store cannot notify, every Get checks the database. A few
// threads read; however many callers need the same read, it is done once. Thread-safe.
class SiteGraphs {
 public:
  using Result = absl::StatusOr<std::shared_ptr<const SiteGraph>>;

  // Adds each site to `changed` whenever a new version of its graph has been read.
  SiteGraphs(const storage::GraphStore& store, ChangedSites& changed);
  ~SiteGraphs();
  SiteGraphs(const SiteGraphs&) = delete;
  SiteGraphs& operator=(const SiteGraphs&) = delete;

  // The current version as far as this process knows. NOT_FOUND if there is no such site. May wait for the database, at
  // most as `context` allows.
  Result Get(const storage::CallContext& context, const SiteId& site);
  // As Get, but null if it would have to wait for the database.
  std::shared_ptr<const SiteGraph> FindCurrent(const SiteId& site) const;
  // Never waits. Calls `then` when Get need not wait any more, in this thread or in one that reads, or with the error
  // of Get; RESOURCE_EXHAUSTED if too many wait already. `then` must not wait.
  void Prepare(const SiteId& site, std::function<void(const absl::Status&)> then);
  // `version` 0: as Get. NOT_FOUND unless it is one of the last few versions that this process has read, or of those
  // before them that are asked for again and again, for example page by page.
  Result GetVersion(const storage::CallContext& context, const SiteId& site, std::int64_t version);
  // Never waits. Calls `then` with a graph that has been read after this, or with the error of Get. Others still get
  // the version that is at hand. `then` must not wait.
  void Refresh(const SiteId& site, std::function<void(const Result&)> then);
  // The caller has changed the site's graph: later calls of Get return a version with the change.
  void MarkChanged(const SiteId& site);

  // The site is gone, or going: its graph is read again if it is asked for.
  void Forget(const SiteId& site);

  // Asks the listening thread to stop, without waiting; the destructor waits.
  void Stop();
  // True after Stop: streams of answers should end.
  bool stopping() const { return stop_.is_set(); }

 private:
  using Waiter = std::function<void(const Result&)>;
  struct KeptVersion {
    std::shared_ptr<const SiteGraph> graph;
    std::chrono::steady_clock::time_point asked_for = {};  // by its number, the last time
  };
  struct Entry {
    std::shared_ptr<const SiteGraph> current;
    std::deque<KeptVersion> recent;    // most recent first
    std::uint64_t changes = 1;         // number of known changes
    std::uint64_t changes_read = 0;    // number of them that `current` includes
    std::uint64_t changes_needed = 1;  // number of them that an answer must include
    bool reading = false;              // a thread reads changes, or will
    std::vector<Waiter> waiters;       // for the next read
  };

  // Calls `waiter` with a graph that is read after this, or known to be current. One read serves all who wait for it.
  void ReadFor(const SiteId& site, Waiter waiter);
  // Runs on the readers: reads the changes, answers the waiters, and goes on while there are more.
  void BringUpToDate(const SiteId& site, const std::shared_ptr<Entry>& entry);
  // Makes what has been read current; it includes `changes` changes.
  void Keep(const SiteId& site, Entry& entry, std::uint64_t changes, const Result& read);
  static void ForgetOldVersions(std::deque<KeptVersion>& recent);
  void Listen();
  // Until the connection is lost or Stop.
  void ProcessChanges(storage::GraphListener& listener);
  void OnGraphChanged(const storage::GraphListener::Change& change);
  // Finds changes of the cached sites whose notifications were lost, for example in a pooler of connections.
  absl::Status CheckVersions();
  void MarkAllChanged();

  const storage::GraphStore& store_;
  ChangedSites& changed_;
  mutable Mutex mutex_;
  // `mutex_` also guards the entries' fields.
  std::unordered_map<SiteId, std::shared_ptr<Entry>> entries_ ABSL_GUARDED_BY(mutex_);
  bool listening_ ABSL_GUARDED_BY(mutex_) = false;
  std::atomic<std::size_t> waiting_ = 0;  // continuations of Prepare
  StopSignal stop_;
  std::stop_source abandoned_;
  Executor readers_;
  std::thread listener_;
};

}  // namespace enfilade::server
