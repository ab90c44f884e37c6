// SPDX-License-Identifier: Apache-2.0
#include "core/slam/state/variance_factor.h"

#include <gtest/gtest.h>

namespace enfilade::slam {
namespace {

TEST(VarianceFactor, IsOneIfNothingIsKnown) { EXPECT_EQ(VarianceFactor({}), 1.0); }

TEST(VarianceFactor, IsTheMeanSquareOfTheMatchesResidualsWithoutLoopClosures) {
  EXPECT_DOUBLE_EQ(VarianceFactor({.match_squares = 25.0, .matches = 100}), 0.25);
  EXPECT_GT(VarianceFactor({.match_squares = 0.0, .matches = 100}), 0.0) << "no error is never certain";
}

TEST(VarianceFactor, IsThatOfTheGraphIfItHasManyLoopClosures) {
  const ErrorStatistics few{.match_squares = 25.0, .matches = 100, .graph_chi2 = 6.0, .redundancy = 6};
  const ErrorStatistics many{.match_squares = 25.0, .matches = 100, .graph_chi2 = 21000.0, .redundancy = 30000};
  EXPECT_GT(VarianceFactor(few), 0.25);
  EXPECT_LT(VarianceFactor(few), 0.5);
  EXPECT_NEAR(VarianceFactor(many), 1.0, 0.01) << "neighbouring closures share 30 % of their freedom";
}

}  // namespace
}  // namespace enfilade::slam
