// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/optimize/indexed_graph.h"
#include "core/optimize/linear/block_structure.h"

namespace enfilade::optimize {

// Where the nodes and edges of a graph are in its block matrices. Depends only on the topology and the held nodes.
struct GraphLayout {
  BlockStructure structure;
  std::vector<int> position;  // per node: its block row in elimination order, -1 where held
  std::vector<int> block;     // per edge: its block below the diagonal, -1 where an end is held
};

GraphLayout LayOut(const IndexedGraph& graph);

}  // namespace enfilade::optimize
