// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/optimize/pose_graph.h"

namespace enfilade::optimize {

// How much of a node's covariance each measurement causes: of each edge k of the graph
//   share_k = Sigma_n J_k^T Omega_k J_k Sigma_n^T,
// with Sigma_n the node's rows of the inverse of H = sum_k J_k^T Omega_k J_k at the graph's poses (the covariance that
// K_k Omega_k^-1 K_k^T with the gain K_k = Sigma_n J_k^T Omega_k propagates from the measurement to the estimate). In
// (x, y, yaw) of T_world_node (m^2, m rad, rad^2). They add up to the node's marginal covariance relative to the held
// nodes. Zero for edges that are disabled or in another component, and for a held node. `fixed` as in SolveOptions;
// kernels do not count. Errors as SolvePoseGraph; FAILED_PRECONDITION: the normal equations are singular.
absl::StatusOr<std::vector<Eigen::Matrix3d>> EdgeShares(const PoseGraph& graph, const std::vector<std::int64_t>& fixed,
                                                        std::int64_t node);

}  // namespace enfilade::optimize
