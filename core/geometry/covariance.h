// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "absl/status/status.h"

namespace enfilade {

// Checks that the matrix is finite, symmetric and positive semi-definite, to one part in 10^9 of its largest element.
// INVALID_ARGUMENT names the property that fails.
absl::Status ValidateCovariance(const Eigen::Matrix3d& covariance);

// Of a measured pose: a standard deviation of 1000 km or 10^6 rad says no more than that nothing is known, and larger
// ones make systems of equations unsolvable. m^2, rad^2.
constexpr double kMaxVariance = 1e12;
// ValidateCovariance, and no variance above kMaxVariance.
absl::Status ValidateMeasuredCovariance(const Eigen::Matrix3d& covariance);

}  // namespace enfilade
