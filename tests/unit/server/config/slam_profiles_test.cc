// SPDX-License-Identifier: Apache-2.0
#include "server/config/slam_profiles.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/slam/slam_options_yaml.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::server {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class SlamProfilesFilesTest : public ::testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& text) {
    const std::filesystem::path path = directory_.path() / name;
    std::ofstream(path) << text;
    return path.string();
  }
  // The text of options with another resolution of the grid.
  static std::string WithResolution(double resolution) {
    slam::SlamOptions options;
    options.resolution = resolution;
    return slam::FormatSlamOptions(options);
  }

  enfilade::testing::TemporaryDirectory directory_;
};

TEST_F(SlamProfilesFilesTest, AreTheDefaultsWithoutFiles) {
  ASSERT_OK_AND_ASSIGN(const slam::SlamProfiles profiles, LoadSlamProfiles({}));
  EXPECT_THAT(profiles.Names(), ElementsAre("indoor", "outdoor"));
  EXPECT_EQ(profiles.Find("indoor")->resolution, slam::SlamOptions().resolution);
}

TEST_F(SlamProfilesFilesTest, TakeTheOptionsFileAsTheirBase) {
  ServerOptions::Mapping options;
  options.slam_options_file = Write("slam.yaml", WithResolution(0.125));
  ASSERT_OK_AND_ASSIGN(const slam::SlamProfiles profiles, LoadSlamProfiles(options));
  EXPECT_EQ(profiles.Find("indoor")->resolution, 0.125);
  EXPECT_EQ(profiles.Find("outdoor")->resolution, 0.125);
}

TEST_F(SlamProfilesFilesTest, AreAddedAndReplacedByTheFilesOfTheFolder) {
  ServerOptions::Mapping options;
  options.slam_profiles_directory = directory_.path().string();
  Write("outdoor.yaml", WithResolution(0.25));
  Write("cellar.yaml", WithResolution(0.5));
  Write("notes.txt", "not: [yaml");
  ASSERT_OK_AND_ASSIGN(const slam::SlamProfiles profiles, LoadSlamProfiles(options));
  EXPECT_THAT(profiles.Names(), ElementsAre("cellar", "indoor", "outdoor"));
  EXPECT_EQ(profiles.Find("outdoor")->resolution, 0.25);
  EXPECT_EQ(profiles.Find("cellar")->resolution, 0.5);
  EXPECT_EQ(profiles.Find("indoor")->resolution, slam::SlamOptions().resolution);
}

TEST_F(SlamProfilesFilesTest, NameTheFileAtFault) {
  ServerOptions::Mapping options;
  options.slam_profiles_directory = directory_.path().string();
  const std::string path = Write("cellar.yaml", "no_such_option: 1\n");
  EXPECT_STATUS(LoadSlamProfiles(options), absl::StatusCode::kInvalidArgument,
                AllOf(HasSubstr(path), HasSubstr("no_such_option")));
  options = {};
  options.slam_options_file = (directory_.path() / "missing.yaml").string();
  EXPECT_STATUS(LoadSlamProfiles(options), absl::StatusCode::kNotFound, HasSubstr("missing.yaml"));
  options = {};
  options.slam_profiles_directory = (directory_.path() / "nowhere").string();
  EXPECT_STATUS(LoadSlamProfiles(options), absl::StatusCode::kNotFound,
                AllOf(HasSubstr("mapping.slam_profiles_directory"), HasSubstr("nowhere")));
}

}  // namespace
}  // namespace enfilade::server
