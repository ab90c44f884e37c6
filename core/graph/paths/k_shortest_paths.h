// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/graph/paths/shortest_paths.h"

namespace enfilade::graph {

// The `count` best paths from `source` to `target` that visit no map or link point twice, best first (Yen 1971).
// `options` must not have exclusions.
std::vector<Path> KShortestPaths(const GraphSnapshot& graph, const PathSource& source, const PathTarget& target,
                                 const PathOptions& options, int count);

}  // namespace enfilade::graph
