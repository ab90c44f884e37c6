// SPDX-License-Identifier: Apache-2.0
// Automatic mapping of the campus "figure1", from the robot's sensors to the solved graph, with one seed of noise.
// `make campus` runs many.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iostream>

#include "tests/e2e/campus/campus_run.h"

namespace enfilade::testing {
namespace {

CampusRun CampusRunOf(const std::vector<std::string>& robots) {
  CampusRun run;
  run.campus = "figure1";
  run.robots = robots;
  return run;
}

void ExpectExact(const CampusResult& result) {
  EXPECT_TRUE(result.comparison.exact) << ::testing::PrintToString(result.comparison.wrong);
  EXPECT_EQ(result.comparison.areas, 4);
  EXPECT_EQ(result.comparison.doors, 5);
  EXPECT_EQ(result.comparison.false_placements, 0);
  EXPECT_EQ(result.comparison.joins_false, 0);
  EXPECT_LT(result.comparison.position_max, 0.6);
}

TEST(Figure1, IsMappedAutomatically) {
  WholeSystem system({});
  const CampusResult result = RunCampus(system, CampusRunOf({"r1"}));
  ExpectExact(result);
  EXPECT_LT(result.final_error, 0.6);
  EXPECT_LT(result.final_yaw_error, 0.07);
  EXPECT_GT(result.poses.samples, 0);
  EXPECT_GT(result.graph.joins.inside, 0);

  const std::filesystem::path way = system.directory() / "way.txt";
  system.Tool(result.site, {"trajectory", "export", "--robot", "r1", "--world", "-o", way.string()});
  std::ifstream in(way);
  int poses = 0;
  double last = 0.0;
  for (double time, x, y, yaw; in >> time >> x >> y >> yaw; last = time) {
    EXPECT_GT(time, last) << "each time once";
    ++poses;
  }
  EXPECT_GT(poses, 500);
}

// Each robot enters areas that the other one enters for the first time, too, by other doors.
TEST(Figure1, IsTheSameGraphWhenTwoRobotsMapItTogether) {
  WholeSystem system({});
  const CampusResult result = RunCampus(system, CampusRunOf({"r1", "r2"}));
  for (const std::string& verdict : result.verdicts) std::cout << verdict << "\n";
  ExpectExact(result);
}

}  // namespace
}  // namespace enfilade::testing
