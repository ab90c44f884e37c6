// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <thread>
#include <unordered_map>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/mutex.h"
#include "server/app/graph/changed_sites.h"
#include "server/app/graph/site_graph.h"
#include "server/app/runtime/stop_signal.h"
#include "storage/call_context.h"
#include "storage/graph/graph_store.h"

namespace enfilade::server {

// The sites' graphs, each cached from its first use. The store notifies a thread of changed graphs (GraphListener),
// which then reads their changes; meanwhile readers get the version before and do not wait. While the store cannot
// notify, every Get checks the database. Thread-safe.
class SiteGraphs {
 public:
  // Adds each site to `changed` whenever a new version of its graph has been read.
  SiteGraphs(const storage::GraphStore& store, ChangedSites& changed);
  ~SiteGraphs();
  SiteGraphs(const SiteGraphs&) = delete;
  SiteGraphs& operator=(const SiteGraphs&) = delete;

  // The current version as far as this process knows. NOT_FOUND if there is no such site. May wait for the database.
  absl::StatusOr<std::shared_ptr<const SiteGraph>> Get(const storage::CallContext& context, const SiteId& site);
  // As Get, but null if it would have to wait for the database.
  std::shared_ptr<const SiteGraph> FindCurrent(const SiteId& site) const;
  // `version` 0: as Get. NOT_FOUND unless it is one of the last few versions that this process has read.
  absl::StatusOr<std::shared_ptr<const SiteGraph>> GetVersion(const storage::CallContext& context, const SiteId& site,
                                                              std::int64_t version);
  // The caller has changed the site's graph: later calls of Get return a version with the change.
  void MarkChanged(const SiteId& site);

  // The site is gone, or going: its graph is read again if it is asked for.
  void Forget(const SiteId& site);

  // Asks the listening thread to stop, without waiting; the destructor waits.
  void Stop();
  // True after Stop: streams of answers should end.
  bool stopping() const { return stop_.is_set(); }

 private:
  struct Entry {
    Mutex reading;  // held while a thread reads changes
    std::shared_ptr<const SiteGraph> current;
    std::deque<std::shared_ptr<const SiteGraph>> recent;  // most recent first
    std::uint64_t changes = 1;                            // number of known changes
    std::uint64_t changes_read = 0;                       // number of them that `current` includes
    std::uint64_t changes_needed = 1;                     // number of them that an answer must include
  };

  std::shared_ptr<Entry> FindOrMake(const SiteId& site);
  // Reads the changes, unless another thread has just read them.
  absl::StatusOr<std::shared_ptr<const SiteGraph>> BringUpToDate(const storage::CallContext& context,
                                                                 const SiteId& site);
  // The current version: `old` itself if nothing has changed since.
  absl::StatusOr<std::shared_ptr<const SiteGraph>> Read(const storage::CallContext& context, const SiteId& site,
                                                        const std::shared_ptr<const SiteGraph>& old) const;
  // The changes since `since` (0: the whole graph), and the last optimisation among them, for graph::Apply.
  struct Update;
  absl::StatusOr<Update> ReadUpdate(const storage::CallContext& context, const SiteId& site, std::int64_t since,
                                    std::int64_t known_solution) const;
  void Listen();
  // Until the connection is lost or Stop.
  void ProcessChanges(storage::GraphListener& listener);
  void OnGraphChanged(const storage::GraphListener::Change& change);
  void MarkAllChanged();

  const storage::GraphStore& store_;
  ChangedSites& changed_;
  mutable Mutex mutex_;
  // `mutex_` also guards the entries' fields, except `reading`.
  std::unordered_map<SiteId, std::shared_ptr<Entry>> entries_ ABSL_GUARDED_BY(mutex_);
  bool listening_ ABSL_GUARDED_BY(mutex_) = false;
  StopSignal stop_;
  std::thread listener_;
};

}  // namespace enfilade::server
