// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/optimize/indexed_graph.h"
#include "core/optimize/minimize.h"

namespace enfilade::optimize {

// A Minimizer by Ceres: Levenberg-Marquardt, sparse normal Cholesky, one thread. The reference that Minimize is tested
// against. `layout` is not used; `options.step_tolerance` has no effect.
Minimum MinimizeWithCeres(const MinimizeOptions& options, const GraphLayout& layout, IndexedGraph& graph);

}  // namespace enfilade::optimize
