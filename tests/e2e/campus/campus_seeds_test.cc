// SPDX-License-Identifier: Apache-2.0
// The command line of campus_seeds; e2e_figure1_test runs what it runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/command.h"
#include "tests/support/test_data.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;

CommandResult RunCampusSeeds(std::vector<std::string> options) {
  options.insert(options.begin(), Program("campus_seeds"));
  return RunCommand(options);
}

TEST(CampusSeeds, HelpListsTheOptionsAndRunsNothing) {
  const CommandResult result = RunCampusSeeds({"--help"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.output, HasSubstr("--delay"));
  EXPECT_THAT(result.output, ::testing::Not(HasSubstr("exact  areas")));
}

TEST(CampusSeeds, BadOptionsAreNamed) {
  const CommandResult range = RunCampusSeeds({"--campus", "random:9-3"});
  EXPECT_EQ(range.exit_code, 2);
  EXPECT_THAT(range.output, HasSubstr("the last is before the first"));
  EXPECT_EQ(RunCampusSeeds({"--campus", "random:a-b"}).exit_code, 2);
  EXPECT_THAT(RunCampusSeeds({"--campus", "suites:a-b"}).output,
              HasSubstr("expected suites:SEED or suites:FIRST-LAST"));
  EXPECT_EQ(RunCampusSeeds({"--delay", "soon"}).exit_code, 2);
  EXPECT_EQ(RunCampusSeeds({"--seeds", "0"}).exit_code, 2);
  EXPECT_EQ(RunCampusSeeds({"--relations", "/none"}).exit_code, 2);
  EXPECT_EQ(RunCampusSeeds({"figure1"}).exit_code, 2);
}

}  // namespace
}  // namespace enfilade::testing
