// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/optimize/indexed_graph.h"

namespace enfilade::optimize {

// The graph's poses with those of all nodes that are not held replaced: each is composed from its neighbour nearer (in
// edges) to a held node and the edge between them.
std::vector<Pose2> SpanningTreePoses(const IndexedGraph& graph);

}  // namespace enfilade::optimize
