// SPDX-License-Identifier: Apache-2.0
// Automatic mapping of the campus "figure1", from the robot's sensors to the solved graph, with one seed of noise.
// `make campus` runs many.
#include <gtest/gtest.h>

#include <iostream>

#include "tests/e2e/campus_run.h"

namespace enfilade::testing {
namespace {

TEST(Figure1, IsMappedAutomatically) {
  WholeSystem system(Cluster::Durability::kFast, {});
  const CampusResult result = RunCampus(system, {.campus = "figure1", .robots = {"r1"}, .seed = 1});
  EXPECT_TRUE(result.exact) << result.graph;
  EXPECT_EQ(result.false_closures, 0);
  EXPECT_LT(result.final_error, 0.6);
  EXPECT_LT(result.final_yaw_error, 0.07);
  EXPECT_GT(result.samples, 0);
}

// Each robot enters areas that the other one enters for the first time, too, by other doors.
TEST(Figure1, IsTheSameGraphWhenTwoRobotsMapItTogether) {
  WholeSystem system(Cluster::Durability::kFast, {});
  const CampusResult result = RunCampus(system, {.campus = "figure1", .robots = {"r1", "r2"}, .seed = 1});
  for (const std::string& verdict : result.verdicts) std::cout << verdict << "\n";
  EXPECT_TRUE(result.exact) << result.graph;
  EXPECT_EQ(result.false_closures, 0);
}

}  // namespace
}  // namespace enfilade::testing
