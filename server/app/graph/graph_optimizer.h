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
#include "server/app/stop_signal.h"
#include "storage/call_context.h"
#include "storage/graph_store.h"

namespace enfilade::server {

struct OptimizedGraph {
  std::int64_t version = 0;  // that it made
  SolvedGraph solution;
};

// Solves sites' graphs: on request, and by itself some time after what is measured in them has changed. A solution is
// stored only where the graph is still at the version that it was made from, so that any number of processes may do the
// same. Readers keep what they have meanwhile. Thread-safe.
class GraphOptimizer {
 public:
  GraphOptimizer(const GraphStore& store, SiteGraphs& graphs, ChangedSites& changed);
  ~GraphOptimizer();
  GraphOptimizer(const GraphOptimizer&) = delete;
  GraphOptimizer& operator=(const GraphOptimizer&) = delete;

  // Now, whether anything has changed or not. FAILED_PRECONDITION where the site has no maps; ABORTED where the graph
  // changed meanwhile, time and again; NOT_FOUND.
  absl::StatusOr<OptimizedGraph> Optimize(const CallContext& context, const SiteId& site);

  // Begins what the destructor waits for.
  void Stop();

 private:
  void Run();
  // Where its solution is not what the graph says now.
  absl::Status OptimizeIfDue(const SiteId& site);

  const GraphStore& store_;
  SiteGraphs& graphs_;
  ChangedSites& changed_;
  StopSignal stop_;
  // Of what was measured when the site was last found solved; the worker's own.
  std::unordered_map<SiteId, std::string> solved_;
  std::thread worker_;
};

}  // namespace enfilade::server
