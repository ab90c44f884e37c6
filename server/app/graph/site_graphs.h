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
#include "storage/graph_store.h"

namespace enfilade::server {

// The sites' graphs, each kept in memory from when it is first asked for. The database says when one changes (LISTEN),
// and a thread brings it up to date by what changed; who asks meanwhile is answered from the version before and does
// not wait. While the database cannot be heard every question looks. Thread-safe.
class SiteGraphs {
 public:
  // Adds to `changed` each site whose graph is read anew, or heard of.
  SiteGraphs(storage::postgres::Pool& pool, const storage::GraphStore& store, ChangedSites& changed);
  ~SiteGraphs();
  SiteGraphs(const SiteGraphs&) = delete;
  SiteGraphs& operator=(const SiteGraphs&) = delete;

  // As far as this process has heard. NOT_FOUND where there is no such site. May wait for the database.
  absl::StatusOr<std::shared_ptr<const SiteGraph>> Get(const storage::CallContext& context, const SiteId& site);
  // The same without ever waiting: null where the database would have to be asked.
  std::shared_ptr<const SiteGraph> FindCurrent(const SiteId& site) const;
  // An earlier version: NOT_FOUND where it is none of the last few that this process has seen.
  absl::StatusOr<std::shared_ptr<const SiteGraph>> GetVersion(const storage::CallContext& context, const SiteId& site,
                                                              std::int64_t version);
  // The caller has changed the site: whoever asks from now on is answered with it.
  void MarkChanged(const SiteId& site);

  // Begins what the destructor waits for; streams of answers should end.
  void Stop();
  bool stopping() const { return stop_.is_set(); }

 private:
  struct Entry {
    Mutex reading;  // one thread at a time reads changes
    std::shared_ptr<const SiteGraph> current;
    std::deque<std::shared_ptr<const SiteGraph>> recent;  // the latest first
    std::uint64_t changes = 1;                            // heard of
    std::uint64_t changes_read = 0;                       // of them, those that `current` has
    std::uint64_t changes_needed = 1;                     // those that an answer must have
  };

  std::shared_ptr<Entry> FindOrMake(const SiteId& site);
  // Reads what has changed, unless somebody just did.
  absl::StatusOr<std::shared_ptr<const SiteGraph>> BringUpToDate(const storage::CallContext& context,
                                                                 const SiteId& site);
  absl::StatusOr<std::shared_ptr<const SiteGraph>> Read(const storage::CallContext& context, const SiteId& site,
                                                        const std::shared_ptr<const SiteGraph>& old) const;
  void Listen();
  // Until the connection is lost or the process stops.
  void Hear(storage::GraphListener& listener);
  void HearOf(const storage::GraphListener::Change& change);
  void MarkAllChanged();

  storage::postgres::Pool& pool_;
  const storage::GraphStore& store_;
  ChangedSites& changed_;
  mutable Mutex mutex_;
  // Entries' fields but `reading` are guarded by `mutex_`, too.
  std::unordered_map<SiteId, std::shared_ptr<Entry>> entries_ ABSL_GUARDED_BY(mutex_);
  bool hearing_ ABSL_GUARDED_BY(mutex_) = false;
  StopSignal stop_;
  std::thread listener_;
};

}  // namespace enfilade::server
