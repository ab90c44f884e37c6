// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/optimize/graph_layout.h"
#include "core/optimize/indexed_graph.h"
#include "core/optimize/minimize.h"

namespace enfilade::optimize {

// Initialisation::kAuto. The cost has many minima: each edge's yaw error is wrapped, and a start decides how often the
// yaws turn around each loop (Carlone and Censi 2014, From Angular Manifolds to the Integer Lattice); for given turns
// one minimum is the rule. So from several starts - the given poses, the chordal relaxation, the poses composed along
// a spanning tree - the one of least cost is minimised first, and a further one only where it turns otherwise around
// some loop than every minimum so far and there is reason to doubt: the least minimum so far is more than noise
// explains (chi-squared test), or the chordal start was not the one of least cost.
// Kernels that flatten out (Cauchy, DCS) make minima of their own, wherever an edge may be taken for wrong: with them
// all this is done with a kernel of ten times the width, from whose minimum the width is narrowed in two steps
// (graduated non-convexity, Blake and Zisserman 1987; Yang et al. 2020).
Minimum MinimizeFromSeveralStarts(const MinimizeOptions& options, const GraphLayout& layout, IndexedGraph& graph);

}  // namespace enfilade::optimize
