// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/optimize/graph_layout.h"
#include "core/optimize/indexed_graph.h"
#include "core/optimize/minimize.h"

namespace enfilade::optimize {

// Initialisation::kAuto. Moves the graph's poses to the lowest minimum found.
//
// The cost has many minima: each edge's yaw error is wrapped, so the start decides how often the yaws turn around each
// loop (Carlone and Censi 2014, From Angular Manifolds to the Integer Lattice). For given turns there is usually one
// minimum. There are up to three starts: the given poses, the chordal relaxation and the poses composed along a
// spanning tree. The start of least cost is minimised first. A further one is tried only if it turns differently around
// some loop than every minimum so far, and there is reason to doubt: noise does not explain the lowest minimum so far
// (chi-squared test), or the chordal start was not the one of least cost.
//
// Redescending kernels (Cauchy, DCS) add minima of their own, one for each choice of edges taken for wrong. With them
// the above is done with ten times the kernel's width, which is then narrowed in two steps (graduated non-convexity,
// Blake and Zisserman 1987; Yang et al. 2020).
Minimum MinimizeFromSeveralStarts(Minimizer minimize, const MinimizeOptions& options, const GraphLayout& layout,
                                  IndexedGraph& graph);

}  // namespace enfilade::optimize
