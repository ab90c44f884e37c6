// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/optimize/graph_layout.h"
#include "core/optimize/indexed_graph.h"
#include "core/optimize/linear/block_cholesky.h"
#include "core/optimize/robust_kernel.h"

namespace enfilade::optimize {

// sum_k rho(e_k^T Omega_k e_k) at the poses.
double GraphCost(const IndexedGraph& graph, const std::vector<Pose2>& poses, const RobustKernel& kernel);

// The Gauss-Newton model of half the cost: H dx = b with H = sum J^T Omega J and b = -sum J^T Omega e, for the steps of
// all free nodes in (x, y, yaw). A kernel scales Omega_k by its weight at the poses (iteratively reweighted least
// squares).
struct NormalEquations {
  BlockMatrix<3> H;
  Eigen::VectorXd b;
};

// At graph.poses. Reuses the memory of `equations`.
void Linearize(const IndexedGraph& graph, const GraphLayout& layout, const RobustKernel& kernel,
               NormalEquations& equations);

// The decrease of the whole cost that the model predicts for the step: 2 b^T dx - dx^T H dx.
double PredictedDecrease(const BlockStructure& structure, const NormalEquations& equations, const Eigen::VectorXd& dx);

// The poses moved by dx; held nodes stay.
std::vector<Pose2> Moved(const GraphLayout& layout, const std::vector<Pose2>& poses, const Eigen::VectorXd& dx);

}  // namespace enfilade::optimize
