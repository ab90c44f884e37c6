// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/base/mutex.h"
#include "core/graph/graph_optimization.h"
#include "server/app/graph/changed_sites.h"
#include "server/app/graph/site_backoff.h"
#include "server/app/graph/site_graphs.h"
#include "server/app/runtime/stop_signal.h"
#include "storage/call_context.h"
#include "storage/graph/graph_store.h"
#include "storage/graph/site_lease_store.h"

namespace enfilade::server {

struct OptimizedGraph {
  std::int64_t version = 0;  // of the graph with the solution
  graph::SolvedGraph solution;
};

// Optimises sites' graphs: on request, and automatically soon after their measurements have changed; two sites at a
// time, so that a large one delays others less. What only adds maps at the rim extends the last solution. The site's
// lease, shared with the closure of doors, ensures that only one process optimises a site at a time. A solution is
// stored only if the graph is still at the version that it was computed from; if that fails repeatedly because the
// graph is edited without a pause, the last attempt locks the graph, and editors wait for it. Readers never wait.
// Thread-safe.
class GraphOptimizer {
 public:
  GraphOptimizer(const storage::GraphStore& store, const storage::SiteLeaseStore& leases, SiteGraphs& graphs,
                 ChangedSites& changed);
  ~GraphOptimizer();
  GraphOptimizer(const GraphOptimizer&) = delete;
  GraphOptimizer& operator=(const GraphOptimizer&) = delete;

  // Optimises immediately, even if nothing has changed. Waits for the site's lease. FAILED_PRECONDITION if the site has
  // no maps; ABORTED if another holder keeps the lease until the deadline; NOT_FOUND.
  absl::StatusOr<OptimizedGraph> Optimize(const storage::CallContext& context, const SiteId& site);

  // Asks the workers to stop, without waiting; the destructor waits.
  void Stop();

 private:
  // The graph that was last solved, and its solution. Null: none yet.
  struct Solved {
    std::shared_ptr<const SiteGraph> graph;
    std::shared_ptr<const graph::SolvedGraph> solution;
  };

  void Run();
  // A site that waits and that no other worker has. Unset: none.
  std::optional<SiteId> TakeWaiting();
  // The site remains to be optimised if that fails; after an error it is left alone for a while.
  void TryToOptimize(const SiteId& site);
  // No-op if the graph's measurements are those that were last solved. ABORTED if another holder has the lease.
  absl::Status OptimizeIfDue(const SiteId& site);
  // The next three: the caller holds the site's lease.
  absl::StatusOr<OptimizedGraph> SolveAndStore(const storage::CallContext& context, const SiteId& site);
  absl::StatusOr<OptimizedGraph> SolveLocked(const storage::CallContext& context, const SiteId& site);
  absl::Status OptimizeChanged(const storage::CallContext& context, const SiteId& site, const SiteGraph& graph,
                               const graph::SolvedGraph& solution);
  Solved LastSolved(const SiteId& site);
  void Remember(const SiteId& site, std::shared_ptr<const SiteGraph> graph, graph::SolvedGraph solution);

  const storage::GraphStore& store_;
  const storage::SiteLeaseStore& leases_;
  SiteGraphs& graphs_;
  ChangedSites& changed_;
  StopSignal stop_;
  const std::string owner_;
  Mutex mutex_;
  std::set<SiteId> waiting_ ABSL_GUARDED_BY(mutex_);
  std::set<SiteId> taken_ ABSL_GUARDED_BY(mutex_);  // by a worker
  std::unordered_map<SiteId, Solved> solved_ ABSL_GUARDED_BY(mutex_);
  SiteBackoff backoff_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::thread> workers_;
};

}  // namespace enfilade::server
