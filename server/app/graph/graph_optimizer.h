// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <thread>
#include <unordered_map>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/graph/graph_optimization.h"
#include "server/app/graph/changed_sites.h"
#include "server/app/graph/site_graphs.h"
#include "server/app/runtime/stop_signal.h"
#include "storage/call_context.h"
#include "storage/graph_store.h"
#include "storage/site_lease_store.h"

namespace enfilade::server {

struct OptimizedGraph {
  std::int64_t version = 0;  // that it made
  graph::SolvedGraph solution;
};

// Solves sites' graphs: on request, and by itself some time after what is measured in them has changed. Whoever solves
// holds the site's lease, as whoever judges its doors, so that of any number of processes one does it; a solution is
// stored only where the graph is still at the version that it was made from, whoever edits it meanwhile. Where it is
// edited without a pause, editors wait for one solution at last; readers never do: they keep what they have meanwhile.
// Thread-safe.
class GraphOptimizer {
 public:
  GraphOptimizer(const storage::GraphStore& store, const storage::SiteLeaseStore& leases, SiteGraphs& graphs,
                 ChangedSites& changed);
  ~GraphOptimizer();
  GraphOptimizer(const GraphOptimizer&) = delete;
  GraphOptimizer& operator=(const GraphOptimizer&) = delete;

  // Now, whether anything has changed or not; waits for whoever holds the site. FAILED_PRECONDITION where the site has
  // no maps; ABORTED where another one holds the site until the deadline; NOT_FOUND.
  absl::StatusOr<OptimizedGraph> Optimize(const storage::CallContext& context, const SiteId& site);

  // Begins what the destructor waits for.
  void Stop();

 private:
  void Run();
  // Where its solution is not what the graph says now. ABORTED where another one holds the site.
  absl::Status OptimizeIfDue(const SiteId& site);
  // Both with the site's lease in hand.
  absl::StatusOr<OptimizedGraph> SolveAndStore(const storage::CallContext& context, const SiteId& site);
  absl::StatusOr<OptimizedGraph> SolveAtRest(const storage::CallContext& context, const SiteId& site);
  absl::Status OptimizeChanged(const storage::CallContext& context, const SiteId& site, const SiteGraph& graph);

  const storage::GraphStore& store_;
  const storage::SiteLeaseStore& leases_;
  SiteGraphs& graphs_;
  ChangedSites& changed_;
  StopSignal stop_;
  // Of what was measured when the site was last found solved; the worker's own.
  std::unordered_map<SiteId, std::string> solved_;
  const std::string owner_;
  std::thread worker_;
};

}  // namespace enfilade::server
