// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/optimize/pose_graph.h"

namespace enfilade::bench {

// A pose graph as the solver Ceres' own 2D pose-graph example poses it: x, y and yaw as three parameter blocks with an
// angle manifold, residuals differentiated automatically, sparse normal Cholesky, the first pose constant, default
// tolerances. Two things differ so that it has the same optimum as ours: the residual is weighted by L^T of
// Omega = L L^T (the example's L is right for diagonal matrices only), and seen in the measurement's frame as g2o does.
struct CeresExampleResult {
  double final_chi2 = 0.0;
  int iterations = 0;
};

// Writes the solution into the graph.
CeresExampleResult SolveAsCeresExample(optimize::PoseGraph& graph);

}  // namespace enfilade::bench
