// SPDX-License-Identifier: Apache-2.0
#include "core/optimize/robust_kernel.h"

#include <gtest/gtest.h>

namespace enfilade::optimize {
namespace {

class RobustKernelTest : public ::testing::TestWithParam<RobustKernel::Type> {};

TEST_P(RobustKernelTest, WeightAndCurvatureAreTheDerivativesOfTheCost) {
  const RobustKernel kernel{GetParam(), 1.7};
  for (const double s : {0.01, 0.5, 2.0, 2.8, 3.0, 10.0, 400.0}) {
    const double h = 1e-4 * s;
    const RobustCost here = Evaluate(kernel, s);
    const RobustCost above = Evaluate(kernel, s + h);
    const RobustCost below = Evaluate(kernel, s - h);
    EXPECT_NEAR(here.weight, (above.cost - below.cost) / (2.0 * h), 1e-6) << s;
    EXPECT_NEAR(here.curvature, (above.weight - below.weight) / (2.0 * h), 1e-5) << s;
  }
}

TEST_P(RobustKernelTest, CountsSmallErrorsAsTheyAre) {
  const RobustCost cost = Evaluate({GetParam(), 2.0}, 1e-6);
  EXPECT_NEAR(cost.cost, 1e-6, 1e-12);
  EXPECT_NEAR(cost.weight, 1.0, 1e-6);
}

TEST_P(RobustKernelTest, JoinsItsBranchesSmoothly) {
  const RobustKernel kernel{GetParam(), 2.0};
  const RobustCost below = Evaluate(kernel, 4.0 - 1e-9);
  const RobustCost above = Evaluate(kernel, 4.0 + 1e-9);
  EXPECT_NEAR(below.cost, above.cost, 1e-8);
  EXPECT_NEAR(below.weight, above.weight, 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Kernels, RobustKernelTest,
                         ::testing::Values(RobustKernel::Type::kNone, RobustKernel::Type::kHuber,
                                           RobustKernel::Type::kCauchy, RobustKernel::Type::kDcs));

// Agarwal et al. 2013, equation 15: the switch is min(1, 2 Phi / (Phi + chi2)), and scales the error.
TEST(RobustKernel, DcsWeighsByTheSquareOfItsSwitch) {
  const RobustKernel kernel{RobustKernel::Type::kDcs, 3.0};
  const double s = 2.0 * 9.0 / (9.0 + 50.0);
  EXPECT_NEAR(Evaluate(kernel, 50.0).weight, s * s, 1e-12);
  EXPECT_EQ(Evaluate(kernel, 8.0).weight, 1.0);
}

}  // namespace
}  // namespace enfilade::optimize
