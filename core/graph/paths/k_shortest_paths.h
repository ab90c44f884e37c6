// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/graph/paths/shortest_paths.h"

namespace enfilade::graph {

// The `count` best paths from `source` to `target` that repeat neither a map nor a link point, the best first (Yen
// 1971). `options` must have no exclusions of its own.
std::vector<Path> KShortestPaths(const GraphSnapshot& graph, const PathSource& source, const PathTarget& target,
                                 const PathOptions& options, int count);

}  // namespace enfilade::graph
