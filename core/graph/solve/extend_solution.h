// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/graph/graph_optimization.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/solved_graph.h"

namespace enfilade::graph {

// The solution of `graph`, where it follows from `solution`, that of its earlier version `solved`, without solving:
// since then nothing has changed but maps that were not posed and now are joined to those that were, each by one way
// only. Such link points contradict nothing, so the optimum keeps all poses, and the new ones are chains. Costs a
// comparison of pointers for each link point, and searches among the new maps. Unset if anything else has changed.
std::optional<SolvedGraph> ExtendSolution(const GraphSnapshot& solved, const SolvedGraph& solution,
                                          const GraphSnapshot& graph, const GraphOptimizationOptions& options = {});

}  // namespace enfilade::graph
