// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
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
// time, so that a large one delays others less. What only adds maps at the rim extends the last solution. A lease
// ensures that only one process solves a site's graph at a time; the lease under which doors are judged is held only
// while the solution is stored, so that judging does not wait for seconds, and is not upset while it is under way. A
// solution is stored only if the graph is still at the version that it was computed from; if that fails repeatedly
// because the graph is edited without a pause, the last attempt locks the graph, and editors wait for it. Readers never
// wait. Thread-safe.
class GraphOptimizer {
 public:
  struct Leases {
    const storage::SiteLeaseStore& solve;
    const storage::SiteLeaseStore& change;
  };

  // A graph that is edited before each attempt is solved at last while nobody else may edit it, unless that would take
  // longer than this: then edits and verdicts on doors come first, and the graph waits for a pause.
  static constexpr std::chrono::milliseconds kLongestLockedSolve{1000};

  GraphOptimizer(const storage::GraphStore& store, const Leases& leases, SiteGraphs& graphs, ChangedSites& changed,
                 std::chrono::milliseconds longest_locked_solve = kLongestLockedSolve);
  ~GraphOptimizer();
  GraphOptimizer(const GraphOptimizer&) = delete;
  GraphOptimizer& operator=(const GraphOptimizer&) = delete;

  // Optimises immediately, even if nothing has changed. Waits for the site's leases. FAILED_PRECONDITION if the site
  // has no maps; ABORTED if another holder keeps one until the deadline, or if a large graph is edited all the time;
  // NOT_FOUND.
  absl::StatusOr<OptimizedGraph> Optimize(const storage::CallContext& context, const SiteId& site);

  // The optimum of `graph`, a version of the site's, in this thread and without storing it: the last solution where it
  // follows from that. FAILED_PRECONDITION if the site has no maps.
  absl::StatusOr<std::shared_ptr<const graph::SolvedGraph>> Solve(const SiteId& site,
                                                                  const graph::GraphSnapshot& graph);

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
  // No-op if the graph's measurements are those that were last solved. ABORTED if another holder has a lease.
  absl::Status OptimizeIfDue(const SiteId& site);
  // The next five: the caller holds the lease on solving.
  // `solution`: if it is known already.
  absl::Status SolveIfChanged(const SiteId& site, const std::shared_ptr<const SiteGraph>& graph,
                              std::optional<graph::SolvedGraph> solution);
  // `last`: of an earlier version, from which the solution may follow.
  absl::StatusOr<OptimizedGraph> SolveAndStore(const storage::CallContext& context, const SiteId& site, Solved last);
  absl::StatusOr<OptimizedGraph> SolveLocked(const storage::CallContext& context, const SiteId& site);
  // Waits for the lease on changes. ABORTED if the graph is no longer at its version, which `is_outdated` says, or if
  // another holder keeps the lease.
  absl::StatusOr<std::int64_t> Store(const storage::CallContext& context, const SiteId& site, const SiteGraph& graph,
                                     const graph::SolvedGraph& solution, bool& is_outdated);
  // What the last solution of `graph` is, if that was found and not stored. Unset: none.
  std::optional<graph::SolvedGraph> TakeUnstored(const SiteId& site, const SiteGraph& graph);
  Solved LastSolved(const SiteId& site);
  void Remember(const SiteId& site, std::shared_ptr<const SiteGraph> graph, graph::SolvedGraph solution);

  const storage::GraphStore& store_;
  const Leases leases_;
  SiteGraphs& graphs_;
  ChangedSites& changed_;
  StopSignal stop_;
  const std::chrono::milliseconds longest_locked_solve_;
  const std::string owner_;
  Mutex mutex_;
  std::set<SiteId> waiting_ ABSL_GUARDED_BY(mutex_);
  std::set<SiteId> taken_ ABSL_GUARDED_BY(mutex_);  // by a worker
  std::unordered_map<SiteId, Solved> solved_ ABSL_GUARDED_BY(mutex_);
  // Found, but the lease for storing them was not to be had.
  std::unordered_map<SiteId, Solved> unstored_ ABSL_GUARDED_BY(mutex_);
  SiteBackoff backoff_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::thread> workers_;
};

}  // namespace enfilade::server
