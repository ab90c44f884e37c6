// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/covariance.h"

#include <Eigen/Eigenvalues>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace enfilade {

absl::Status ValidateCovariance(const Eigen::Matrix3d& covariance) {
  if (!covariance.allFinite()) return InvalidArgument("the covariance is not finite");
  const double tolerance = 1e-9 * covariance.cwiseAbs().maxCoeff();
  if ((covariance - covariance.transpose()).cwiseAbs().maxCoeff() > tolerance) {
    return InvalidArgument("the covariance is not symmetric");
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  if (solver.eigenvalues().minCoeff() < -tolerance) {
    return InvalidArgument("the covariance is not positive semi-definite: it has the eigenvalue {}",
                           solver.eigenvalues().minCoeff());
  }
  return absl::OkStatus();
}

absl::Status ValidateMeasuredCovariance(const Eigen::Matrix3d& covariance) {
  ENFILADE_RETURN_IF_ERROR(ValidateCovariance(covariance));
  const double largest = covariance.diagonal().maxCoeff();
  if (largest <= kMaxVariance) return absl::OkStatus();
  return InvalidArgument("the covariance has the variance {}: expected at most {}", largest, kMaxVariance);
}

}  // namespace enfilade
