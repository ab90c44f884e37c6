// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/optimize/edge_error.h"

namespace ceres {
class CostFunction;
}

namespace enfilade::optimize {

// A pose graph's edge for Ceres, as new as ceres::Problem wants it (the caller owns it): the residual L^T e with
// Omega = L L^T, so that its square is e^T Omega e, of two parameter blocks (x, y, yaw) in the world frame, with
// analytic Jacobians. The yaw error is wrapped; the blocks need no manifold.
ceres::CostFunction* NewEdgeCost(const EdgeMeasurement& measurement, const Eigen::Matrix3d& information);

}  // namespace enfilade::optimize
