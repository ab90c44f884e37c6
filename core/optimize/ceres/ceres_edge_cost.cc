// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/ceres/ceres_edge_cost.h"

#include <Eigen/Cholesky>

#include "ceres/sized_cost_function.h"

namespace enfilade::optimize {
namespace {

class EdgeCost : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  EdgeCost(const EdgeMeasurement& measurement, const Eigen::Matrix3d& information)
      : measurement_(measurement), L_T_(information.llt().matrixU()) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    using Jacobian = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
    const Pose2 T_world_from{parameters[0][0], parameters[0][1], parameters[0][2]};
    const Pose2 T_world_to{parameters[1][0], parameters[1][1], parameters[1][2]};
    const LinearizedEdge edge = LinearizeEdge(T_world_from, T_world_to, measurement_);
    Eigen::Map<Eigen::Vector3d> weighted_error(residuals);
    weighted_error = L_T_ * edge.error;
    if (jacobians && jacobians[0]) {
      Jacobian by_from(jacobians[0]);
      by_from = L_T_ * edge.J_from();
    }
    if (jacobians && jacobians[1]) {
      Jacobian by_to(jacobians[1]);
      by_to = L_T_ * edge.J_to;
    }
    return true;
  }

 private:
  EdgeMeasurement measurement_;
  Eigen::Matrix3d L_T_;
};

}  // namespace

ceres::CostFunction* NewEdgeCost(const EdgeMeasurement& measurement, const Eigen::Matrix3d& information) {
  return new EdgeCost(measurement, information);
}

}  // namespace enfilade::optimize
