// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/optimize/robust_kernel.h"

namespace enfilade::optimize {

struct GraphLayout;
struct IndexedGraph;

enum class Backend {
  kBlocks,  // ours: 3 x 3 blocks, variable projection
  kCeres,   // Ceres: Levenberg-Marquardt, sparse normal Cholesky, one thread; the reference that ours is tested against
};

struct MinimizeOptions {
  Backend backend = Backend::kBlocks;
  RobustKernel kernel = {};
  int max_iterations = 100;
  double relative_tolerance = 1e-9;
  double step_tolerance = 1e-10;
};

struct Minimum {
  double cost = 0.0;
  int iterations = 0;  // steps tried
  bool converged = false;
};

// Moves the graph's poses to the minimum of its cost whose valley they are in, by Gauss-Newton steps, damped (Levenberg
// 1944, Marquardt 1963) where they do not descend. Where the cost fell clearly less than a step's model said, the step
// is taken in the yaws only and followed by SolveTranslations (variable projection, Golub and Pereyra 1973): relative
// poses known to tenths of a millimetre make narrow valleys, bent because the translations turn with the yaws, in
// which straight steps all but stop. (Backend::kCeres has steps of its own.)
Minimum Minimize(const MinimizeOptions& options, const GraphLayout& layout, IndexedGraph& graph);

}  // namespace enfilade::optimize
