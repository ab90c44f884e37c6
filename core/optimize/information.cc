// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/information.h"

#include <Eigen/Cholesky>

#include "core/base/error.h"

namespace enfilade::optimize {

absl::Status CheckInformation(const Eigen::Matrix3d& information) {
  if (!information.allFinite()) return InvalidArgument("its information matrix is not finite");
  if ((information - information.transpose()).cwiseAbs().maxCoeff() > 1e-9 * information.cwiseAbs().maxCoeff()) {
    return InvalidArgument("its information matrix is not symmetric");
  }
  if (information.llt().info() != Eigen::Success) {
    return InvalidArgument("its information matrix is not positive definite");
  }
  return absl::OkStatus();
}

}  // namespace enfilade::optimize
