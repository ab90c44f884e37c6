// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/optimize/graph_layout.h"
#include "core/optimize/indexed_graph.h"
#include "core/optimize/robust_kernel.h"

namespace enfilade::optimize {

// Given all yaws the chi2 is quadratic in the translations: replaces those of the nodes that are not held by the
// minimiser. Edges count with the kernel's weights at `weighted_at` (with kernel kNone: with 1).
// False, and no change, if the equations are singular to the machine's precision.
bool SolveTranslations(const IndexedGraph& graph, const GraphLayout& layout, const RobustKernel& kernel,
                       const std::vector<Pose2>& weighted_at, std::vector<Pose2>& poses);

}  // namespace enfilade::optimize
