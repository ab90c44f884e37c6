// Automatic mapping of the campus of figure 1, from the robot's sensors to the solved graph: one seed of noise. `make
// figure1` does many.
#include <gtest/gtest.h>

#include "tests/e2e/figure1_run.h"

namespace enfilade::testing {
namespace {

TEST(Figure1, IsMappedWithoutAHandOnIt) {
  WholeSystem system(Cluster::Durability::kFast, {});
  const Figure1Result result = RunFigure1(system, 1, {"r1"});
  EXPECT_TRUE(result.exact) << result.graph;
  EXPECT_EQ(result.false_closures, 0);
  EXPECT_LT(result.final_error, 0.6);
  EXPECT_LT(result.final_yaw_error, 0.07);
  EXPECT_GT(result.samples, 0);
}

}  // namespace
}  // namespace enfilade::testing
