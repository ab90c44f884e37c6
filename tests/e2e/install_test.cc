// SPDX-License-Identifier: Apache-2.0
// A robot's own program, built against what `cmake --install` lays down.
#include <gtest/gtest.h>

#include "tests/e2e/whole_system.h"
#include "tests/support/command.h"

namespace enfilade::testing {
namespace {

void RunOrFail(const std::vector<std::string>& command) {
  const CommandResult result = RunCommand(command);
  ASSERT_EQ(result.exit_code, 0) << result.output;
}

TEST(Install, ExampleBuildsAgainstTheInstalledPackageAndBringsItsRecordsToTheServer) {
  WholeSystem system(Cluster::Durability::kFast, {});
  system.CreateSite("s");
  const std::string prefix = (system.directory() / "prefix").string();
  const std::string build = (system.directory() / "example").string();
  ASSERT_NO_FATAL_FAILURE(RunOrFail({"cmake", "--install", ENFILADE_BUILD_DIR, "--prefix", prefix}));
  ASSERT_NO_FATAL_FAILURE(RunOrFail({"cmake", "-G", "Ninja", "-S", ProjectFile("examples/robot_client"), "-B", build,
                                     "-DCMAKE_PREFIX_PATH=" + prefix, "-DCMAKE_CXX_FLAGS=" ENFILADE_BUILD_FLAGS}));
  ASSERT_NO_FATAL_FAILURE(RunOrFail({"cmake", "--build", build}));

  const std::vector<std::string> robot = {build + "/robot_client", system.server().address(), "s",
                                          (system.directory() / "robot.spool").string()};
  ASSERT_NO_FATAL_FAILURE(RunOrFail(robot));
  EXPECT_EQ(system.Query("SELECT acknowledged_sequence FROM enfilade.sessions WHERE session_id = 'first-drive'"), "42");
  EXPECT_TRUE(Eventually([&] {
    return system.Query("SELECT state FROM enfilade.sessions WHERE session_id = 'first-drive'") == "3";
  })) << "not mapped";
  // Once more: all is there already.
  ASSERT_NO_FATAL_FAILURE(RunOrFail(robot));
  EXPECT_EQ(system.Query("SELECT count(*) FROM enfilade.session_records"), "42");
}

}  // namespace
}  // namespace enfilade::testing
