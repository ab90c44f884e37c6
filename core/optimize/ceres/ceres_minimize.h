// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/optimize/indexed_graph.h"
#include "core/optimize/minimize.h"

namespace enfilade::optimize {

// Backend::kCeres of Minimize.
Minimum MinimizeWithCeres(const MinimizeOptions& options, IndexedGraph& graph);

}  // namespace enfilade::optimize
