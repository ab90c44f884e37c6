// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "absl/status/status.h"

namespace enfilade::optimize {

// INVALID_ARGUMENT, naming the reason, unless the matrix is finite, symmetric and positive definite.
absl::Status CheckInformation(const Eigen::Matrix3d& information);

}  // namespace enfilade::optimize
