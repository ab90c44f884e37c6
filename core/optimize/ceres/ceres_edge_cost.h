// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/optimize/edge_error.h"

namespace ceres {
class CostFunction;
}

namespace enfilade::optimize {

// The cost of one pose-graph edge for ceres::Problem, which takes ownership. With Omega = L L^T the residual is L^T e,
// whose squared norm is e^T Omega e. It depends on two parameter blocks (x, y, yaw) in the world frame and has analytic
// Jacobians. The yaw error is wrapped, so the blocks need no manifold.
ceres::CostFunction* NewEdgeCost(const EdgeMeasurement& measurement, const Eigen::Matrix3d& information);

}  // namespace enfilade::optimize
