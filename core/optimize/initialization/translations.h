// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/optimize/graph_layout.h"
#include "core/optimize/indexed_graph.h"
#include "core/optimize/robust_kernel.h"

namespace enfilade::optimize {

// With all yaws given, chi2 is quadratic in the translations: replaces the translations of the free nodes by the
// minimiser. Edges count with the kernel's weights at `weighted_at` (with 1 for kernel kNone).
// False, and `poses` unchanged, if the equations are numerically singular.
bool SolveTranslations(const IndexedGraph& graph, const GraphLayout& layout, const RobustKernel& kernel,
                       const std::vector<Pose2>& weighted_at, std::vector<Pose2>& poses);

}  // namespace enfilade::optimize
