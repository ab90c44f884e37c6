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

// The Gauss-Newton model of half of the cost: H dx = b for the steps of all nodes that are not held, in (x, y, yaw) of
// their poses. With a kernel, Omega_k is scaled by its weight at the poses (iteratively reweighted least squares).
struct NormalEquations {
  BlockMatrix<3> H;
  Eigen::VectorXd b;
};

// Writes into `equations`, whose memory is used again.
void Linearize(const IndexedGraph& graph, const GraphLayout& layout, const RobustKernel& kernel,
               NormalEquations& equations);

// By how much the step lowers the model of the (whole) cost: 2 b^T dx - dx^T H dx.
double PredictedDecrease(const BlockStructure& structure, const NormalEquations& equations, const Eigen::VectorXd& dx);

// The poses moved by dx.
std::vector<Pose2> Moved(const GraphLayout& layout, const std::vector<Pose2>& poses, const Eigen::VectorXd& dx);

}  // namespace enfilade::optimize
