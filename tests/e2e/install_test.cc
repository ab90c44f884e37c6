// SPDX-License-Identifier: Apache-2.0
// The examples, built against what `cmake --install` installs.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/e2e/whole_system.h"
#include "tests/support/command.h"

namespace enfilade::testing {
namespace {

void RunOrFail(const std::vector<std::string>& command) {
  const CommandResult result = RunCommand(command);
  ASSERT_EQ(result.exit_code, 0) << result.output;
}

class Install : public ::testing::Test {
 protected:
  Install() : system_({}) { system_.CreateSite("s"); }

  void InstallAll() {
    ASSERT_NO_FATAL_FAILURE(RunOrFail({"cmake", "--install", ENFILADE_BUILD_DIR, "--prefix", prefix_}));
  }
  // Builds examples/NAME; its program is BUILD/NAME.
  std::string Build(const std::string& name) {
    const std::string build = (system_.directory() / name).string();
    RunOrFail({"cmake", "-G", "Ninja", "-S", ProjectFile("examples/" + name), "-B", build,
               "-DCMAKE_PREFIX_PATH=" + prefix_, "-DCMAKE_CXX_FLAGS=" ENFILADE_BUILD_FLAGS});
    RunOrFail({"cmake", "--build", build});
    return build + "/" + name;
  }

  WholeSystem system_;
  const std::string prefix_ = (system_.directory() / "prefix").string();
};

TEST_F(Install, ExamplesBuildAgainstTheInstalledPackageAndTalkToTheServer) {
  ASSERT_NO_FATAL_FAILURE(InstallAll());
  const std::string robot_client = Build("robot_client");
  ASSERT_FALSE(HasFatalFailure());
  const std::vector<std::string> robot = {robot_client, system_.server().address(), "s",
                                          (system_.directory() / "robot.spool").string()};
  ASSERT_NO_FATAL_FAILURE(RunOrFail(robot));
  EXPECT_EQ(system_.Query("SELECT acknowledged_sequence FROM enfilade.sessions WHERE session_id = 'first-drive'"),
            "42");
  EXPECT_TRUE(Eventually([&] {
    return system_.Query("SELECT state FROM enfilade.sessions WHERE session_id = 'first-drive'") == "3";
  })) << "not mapped";
  // A second run finds everything acknowledged.
  ASSERT_NO_FATAL_FAILURE(RunOrFail(robot));
  EXPECT_EQ(system_.Query("SELECT count(*) FROM enfilade.session_records"), "42");

  // The map that the robot made, as files.
  const std::string map_client = Build("map_client");
  ASSERT_FALSE(HasFatalFailure());
  const std::string out = (system_.directory() / "maps").string();
  ASSERT_NO_FATAL_FAILURE(RunOrFail({map_client, system_.server().address(), "s", out}));
  EXPECT_TRUE(std::filesystem::exists(out + "/Square-room.png"));
}

}  // namespace
}  // namespace enfilade::testing
