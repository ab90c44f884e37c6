// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/optimize/indexed_graph.h"

namespace enfilade::optimize {

// The poses composed along a breadth-first spanning tree: each free node's from a neighbour that is fewer edges from a
// held node, and the edge between them. Held nodes keep their poses.
std::vector<Pose2> SpanningTreePoses(const IndexedGraph& graph);

}  // namespace enfilade::optimize
