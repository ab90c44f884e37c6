// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/optimize/robust_kernel.h"

namespace enfilade::optimize {

struct GraphLayout;
struct IndexedGraph;

struct MinimizeOptions {
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

// Moves the graph's poses from where they are to a local minimum of its cost.
using Minimizer = Minimum (*)(const MinimizeOptions& options, const GraphLayout& layout, IndexedGraph& graph);

// The default Minimizer. It takes Gauss-Newton steps, damped (Levenberg 1944, Marquardt 1963) when they do not descend.
// When the cost falls clearly less than a step's model predicts, only the step's yaws are taken, followed by
// SolveTranslations (variable projection, Golub and Pereyra 1973). The reason: relative poses known to tenths of a
// millimetre make narrow valleys in the cost, bent because the translations turn with the yaws, and along these
// straight steps make hardly any progress.
Minimum Minimize(const MinimizeOptions& options, const GraphLayout& layout, IndexedGraph& graph);

}  // namespace enfilade::optimize
