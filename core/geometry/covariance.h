// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "absl/status/status.h"

namespace enfilade {

// Checks that the matrix is finite, symmetric and positive semi-definite, to one part in 10^9 of its largest element.
// INVALID_ARGUMENT names the property that fails.
absl::Status ValidateCovariance(const Eigen::Matrix3d& covariance);

}  // namespace enfilade
