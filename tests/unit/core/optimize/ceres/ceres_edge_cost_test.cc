// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/ceres/ceres_edge_cost.h"

#include <gtest/gtest.h>

#include <memory>

#include "ceres/cost_function.h"

namespace enfilade::optimize {
namespace {

class CeresEdgeCostTest : public ::testing::Test {
 protected:
  using Jacobian = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

  Eigen::Vector3d Residual(const Eigen::Vector3d& from, const Eigen::Vector3d& to, Jacobian* by_from = nullptr,
                           Jacobian* by_to = nullptr) const {
    const double* parameters[] = {from.data(), to.data()};
    double* jacobians[] = {by_from ? by_from->data() : nullptr, by_to ? by_to->data() : nullptr};
    Eigen::Vector3d residual;
    EXPECT_TRUE(cost_->Evaluate(parameters, residual.data(), jacobians));
    return residual;
  }

  const EdgeMeasurement measurement_{Pose2{0.7, 1.9, -1.1}};
  const Eigen::Matrix3d information_ = (Eigen::Matrix3d() << 40, 12, -9, 12, 25, 6, -9, 6, 90).finished();
  const std::unique_ptr<ceres::CostFunction> cost_{NewEdgeCost(measurement_, information_)};
  const Eigen::Vector3d from_{1.2, -3.4, 2.9};
  const Eigen::Vector3d to_{-0.6, 2.2, -2.5};
};

// L e instead of L^T e would pass with a diagonal matrix only.
TEST_F(CeresEdgeCostTest, SquaresToTheMahalanobisErrorOfAFullMatrix) {
  const Eigen::Vector3d e = EdgeError({1.2, -3.4, 2.9}, {-0.6, 2.2, -2.5}, measurement_);
  EXPECT_NEAR(Residual(from_, to_).squaredNorm(), e.dot(information_ * e), 1e-9);
}

TEST_F(CeresEdgeCostTest, JacobiansAgreeWithFiniteDifferences) {
  Jacobian by_from;
  Jacobian by_to;
  Residual(from_, to_, &by_from, &by_to);
  constexpr double h = 1e-6;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d d = h * Eigen::Vector3d::Unit(axis);
    EXPECT_LT((by_from.col(axis) - (Residual(from_ + d, to_) - Residual(from_ - d, to_)) / (2.0 * h)).norm(), 1e-6);
    EXPECT_LT((by_to.col(axis) - (Residual(from_, to_ + d) - Residual(from_, to_ - d)) / (2.0 * h)).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace enfilade::optimize
