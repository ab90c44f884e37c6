// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/optimize/minimize.h"
#include "core/optimize/pose_graph.h"
#include "core/optimize/robust_kernel.h"

namespace enfilade::optimize {

enum class Initialisation {
  kNone,     // the given poses: for a warm start
  kChordal,  // chordal relaxation (Carlone et al. 2015); the given poses are used only where a node is held
  kAuto,     // several starts, the given poses among them; the lowest minimum found (starts.h)
};

struct SolveOptions {
  Initialisation initialisation = Initialisation::kAuto;

  // Applied to edges with `robust`. The width is in standard deviations (see RobustKernel).
  RobustKernel kernel = {};

  Minimizer minimizer = &Minimize;  // or MinimizeWithCeres (ceres/ceres_minimize.h)

  int max_iterations = 100;  // Gauss-Newton / Levenberg-Marquardt steps per start
  // Converged when a step lowers the cost by no more than this fraction of it, or moves no pose by more than
  // `step_tolerance` (m, rad).
  double relative_tolerance = 1e-9;
  double step_tolerance = 1e-10;

  // Ids of the nodes held at their given poses. A component without any has its first node held.
  std::vector<std::int64_t> fixed = {};

  // Ids of the nodes whose marginal covariance is wanted.
  std::vector<std::int64_t> covariance_of = {};
};

// The marginal covariance of one node in (x, y, yaw) of its T_world_node, relative to the held nodes of its component
// (m^2, m rad, rad^2): zero for a held node. With a kernel, edges count with their final weights.
struct NodeCovariance {
  std::int64_t id = 0;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

struct SolveReport {
  // Sum of e^T Omega e over the enabled edges, without kernel: at the given poses and at the result.
  double initial_chi2 = 0.0;
  double final_chi2 = 0.0;
  // The same with the kernel: what is minimised. Equal to chi2 without a kernel.
  double initial_cost = 0.0;
  double final_cost = 0.0;
  // At the result, without kernel: one per edge in the graph's order, disabled edges included.
  std::vector<double> edge_chi2;
  // The kernel's final weight of each edge in [0, 1]: 1 = counts fully, 0 = disabled or rejected.
  std::vector<double> edge_weight;

  int iterations = 0;                       // steps taken, over all starts
  bool converged = false;                   // in every component
  int components = 0;                       // connected by enabled edges; a node without edges is one
  std::vector<NodeCovariance> covariances;  // in the order of `covariance_of`
};

// Minimises sum_k rho(e_k^T Omega_k e_k) over the poses and writes them into `graph`. Each component is solved on its
// own: only its held nodes fix where it lies. An empty graph is valid.
// Errors (the graph is unchanged): INVALID_ARGUMENT for a duplicate id, an edge to an absent node or to itself, a
// number that is not finite, an information matrix that is not symmetric positive definite, an unknown id in the
// options.
absl::StatusOr<SolveReport> SolvePoseGraph(const SolveOptions& options, PoseGraph& graph);

}  // namespace enfilade::optimize
