// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "absl/status/status.h"

namespace enfilade {

// INVALID_ARGUMENT saying what is wrong unless the matrix is finite, symmetric and positive semi-definite, each to one
// part in 10^9 of its largest element.
absl::Status ValidateCovariance(const Eigen::Matrix3d& covariance);

}  // namespace enfilade
