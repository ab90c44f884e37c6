// SPDX-License-Identifier: Apache-2.0
// What people type, and what they and programs read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "client/cli/command.h"
#include "client/cli/entry_options.h"
#include "client/cli/log_options.h"
#include "client/cli/map_file_reader.h"
#include "client/cli/numbers.h"
#include "client/cli/output.h"
#include "client/cli/pose_in_map.h"
#include "io/file.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::cli {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ParseNumberTest, TakesOneFiniteNumberAndNothingElse) {
  EXPECT_EQ(ParseNumber("1.5"), 1.5);
  EXPECT_EQ(ParseNumber("-2e3"), -2000.0);
  EXPECT_EQ(ParseNumber("+0"), 0.0);
  for (const std::string text : {"", "x", "1x", "1 ", "1,2", "nan", "inf", "-inf", "1e999", "--1", "."}) {
    EXPECT_EQ(ParseNumber(text), std::nullopt) << '"' << text << '"';
  }
}

TEST(ParseNumbersTest, TakesExactlyAsManyAsAreAskedFor) {
  EXPECT_THAT(ParseNumbers("1,2.5,-3", 3).value_or(std::vector<double>{}), ElementsAre(1.0, 2.5, -3.0));
  EXPECT_THAT(ParseNumbers("7", 1).value_or(std::vector<double>{}), ElementsAre(7.0));
  for (const std::string text : {"", "1", "1,2", "1,2,3,4", "1,,3", ",1,2", "1,2,", "1,2,x", "1;2;3", "1,2,nan"}) {
    EXPECT_EQ(ParseNumbers(text, 3), std::nullopt) << '"' << text << '"';
  }
}

TEST(ParseRateTest, KnowsMaxRealAndPositiveFactors) {
  EXPECT_EQ(*ParseRate("max"), std::nullopt);
  EXPECT_EQ(*ParseRate("real"), 1.0);
  EXPECT_EQ(*ParseRate("0.25"), 0.25);
  for (const std::string text : {"", "0", "-1", "inf", "nan", "fast", "2x", "MAX"}) {
    EXPECT_STATUS(ParseRate(text), absl::StatusCode::kInvalidArgument, HasSubstr("\"" + text + "\""));
  }
}

TEST(ParsePoseInMapTest, ReadsTheNumbersFromTheEnd) {
  struct Case {
    std::string text;
    std::string map;
    Pose2 pose;
  };
  const std::vector<Case> cases = {
      {"Hall,1,2", "Hall", {1.0, 2.0, 0.0}},
      {"Hall,1,2,0.5", "Hall", {1.0, 2.0, 0.5}},
      {"Main hall,-1.5,2e1,-3", "Main hall", {-1.5, 20.0, -3.0}},
      {"Hall, east,1,2,3", "Hall, east", {1.0, 2.0, 3.0}},
      {"Room 1,2,3", "Room 1", {2.0, 3.0, 0.0}},
      {"7,1,2,3", "7", {1.0, 2.0, 3.0}},
      {"1,2,3,4,5", "1,2", {3.0, 4.0, 5.0}},
      {"sites/s/maps/m,0,0,0", "sites/s/maps/m", {0.0, 0.0, 0.0}},
  };
  for (const Case& test : cases) {
    ASSERT_OK_AND_ASSIGN(const PoseInMap pose, ParsePoseInMap(test.text));
    EXPECT_EQ(pose.map, test.map) << test.text;
    EXPECT_EQ(pose.pose, test.pose) << test.text;
  }
}

TEST(ParsePoseInMapTest, SaysWhatIsExpectedOtherwise) {
  for (const std::string text :
       {"", "Hall", "Hall,1", "Hall,1,x", "Hall,x,1", ",1,2", "Hall,1,nan", "Hall;1;2", "Hall,1,2,"}) {
    EXPECT_STATUS(ParsePoseInMap(text), absl::StatusCode::kInvalidArgument, HasSubstr("MAP,X,Y")) << text;
  }
}

TEST(EntryOptionsTest, APoseComesWithItsUncertainty) {
  ASSERT_OK_AND_ASSIGN(const auto none, EntryOf({}));
  EXPECT_FALSE(none.has_value());
  ASSERT_OK_AND_ASSIGN(const auto entry, EntryOf({"1,-2,4", "0.5,0.1"}));
  ASSERT_TRUE(entry.has_value());
  EXPECT_EQ(entry->pose.x, 1.0);
  EXPECT_EQ(entry->pose.y, -2.0);
  EXPECT_NEAR(entry->pose.yaw, 4.0 - 2.0 * M_PI, 1e-12);
  const Eigen::Matrix3d expected = Eigen::Vector3d(0.25, 0.25, 0.01).asDiagonal();
  EXPECT_TRUE(entry->covariance.isApprox(expected));
}

TEST(EntryOptionsTest, RefusesWhatIsNoPoseOrNoUncertainty) {
  for (const std::string at : {"1", "1,2", "1,2,3,4", "a,b,c", "1,2,inf"}) {
    EXPECT_STATUS(EntryOf({at}), absl::StatusCode::kInvalidArgument, HasSubstr("X,Y,YAW")) << at;
  }
  for (const std::string sigma : {"", "1", "0,1", "1,0", "-1,1", "1,2,3", "x,y"}) {
    EXPECT_STATUS(EntryOf({"1,2,3", sigma}), absl::StatusCode::kInvalidArgument, HasSubstr("--at-sigma")) << sigma;
  }
}

TEST(LogOptionsTest, TheFieldOfViewIsGivenInDegrees) {
  sources::LogOptions options;
  CLI::App app;
  AddLogOptions(app, options);
  AddNoOdometry(app, options);
  app.parse("--fov 180 --range-max 25 --skip-bad-lines --no-odometry");
  ASSERT_TRUE(options.field_of_view.has_value());
  EXPECT_NEAR(*options.field_of_view, M_PI, 1e-12);
  EXPECT_EQ(options.range_max, 25.0F);
  EXPECT_TRUE(options.skip_bad_lines);
  EXPECT_FALSE(options.odometry);
  for (const char* fov : {"--fov 0", "--fov 361", "--fov wide"}) EXPECT_THROW(app.parse(fov), CLI::ParseError) << fov;
}

TEST(FormatTest, BytesUseTheLargestUnitBelowThem) {
  const std::pair<std::int64_t, const char*> cases[] = {{0, "0 B"},
                                                        {1, "1 B"},
                                                        {1024, "1.0 KiB"},
                                                        {1024 * 1024 - 53, "1023.9 KiB"},
                                                        {1LL << 30, "1.0 GiB"},
                                                        {5LL << 40, "5.0 TiB"},
                                                        {5000LL << 40, "5000.0 TiB"}};
  for (const auto& [bytes, text] : cases) EXPECT_EQ(FormatBytes(bytes), text);
}

TEST(FormatTest, SecondsTurnIntoMinutesAndHours) {
  const std::pair<double, const char*> cases[] = {{0.0, "0.00 s"},     {9.994, "9.99 s"},     {9.996, "10.0 s"},
                                                  {59.94, "59.9 s"},   {60.0, "1:00"},        {3599.4, "59:59"},
                                                  {3599.6, "1:00:00"}, {86400.0, "24:00:00"}, {-1.0, "?"},
                                                  {1e10, "?"},         {std::nan(""), "?"}};
  for (const auto& [seconds, text] : cases) EXPECT_EQ(FormatSeconds(seconds), text) << seconds;
}

TEST(FormatTest, EnumsLoseTheirPrefix) {
  EXPECT_EQ(EnumText("KIND_DOOR", "KIND_"), "door");
  EXPECT_EQ(EnumText("DECISION_LINK_POINT_RECOGNISED", "DECISION_"), "link point recognised");
  EXPECT_EQ(EnumText("DOOR", "KIND_"), "door");
  EXPECT_EQ(EnumText("KIND_", "KIND_"), "");
  EXPECT_EQ(EnumText("", "KIND_"), "");
}

TEST(PrintTableTest, HandlesEmptyTablesAndShortRows) {
  std::ostringstream out;
  PrintTable(out, {"A", "B"}, {});
  EXPECT_EQ(out.str(), "A  B\n");
  out.str("");
  PrintTable(out, {"A", "B"}, {{"wide cell"}, {"", "x"}});
  EXPECT_EQ(out.str(), "A          B\nwide cell\n           x\n");
}

TEST(ExitCodeTest, TellsUsageMissingAndAwayApart) {
  const std::pair<absl::Status, int> cases[] = {
      {absl::OkStatus(), 0},           {absl::InvalidArgumentError(""), 2},  {absl::NotFoundError(""), 3},
      {absl::UnavailableError(""), 4}, {absl::DeadlineExceededError(""), 4}, {absl::PermissionDeniedError(""), 1},
      {absl::DataLossError(""), 1},    {absl::CancelledError(""), 1}};
  for (const auto& [status, code] : cases) EXPECT_EQ(ExitCodeOf(status), code) << status;
}

TEST(AddCommandTest, AnErrorLeavesTheParserAsCommandFailed) {
  CLI::App app;
  AddCommand(app, "fail", "", [] { return absl::NotFoundError("gone"); });
  AddCommand(app, "pass", "", [] { return absl::OkStatus(); });
  EXPECT_NO_THROW(app.parse("pass"));
  try {
    app.parse("fail");
    FAIL() << "no error";
  } catch (const CommandFailed& failed) {
    EXPECT_EQ(failed.status, absl::NotFoundError("gone"));
  }
}

class MapFilesTest : public ::testing::Test {
 protected:
  std::filesystem::path File(const std::string& name, const std::string& bytes) const {
    EXPECT_OK(io::WriteFile(directory_.path() / name, bytes));
    return directory_.path() / name;
  }
  static std::string Yaml(const std::string& image) {
    return "image: " + image +
           "\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n";
  }
  enfilade::testing::TemporaryDirectory directory_;
};

TEST_F(MapFilesTest, AYamlBringsTheImageThatItNames) {
  File("floor.pgm", "P5");
  ASSERT_OK_AND_ASSIGN(const auto files, ReadMapFiles(File("hall.yaml", Yaml("floor.pgm"))));
  ASSERT_EQ(files.size(), 2U);
  EXPECT_EQ(files[0].name, "hall.yaml");
  EXPECT_EQ(files[1].name, "floor.pgm");
  EXPECT_EQ(files[1].bytes, "P5");
  ASSERT_OK_AND_ASSIGN(const auto json, ReadMapFiles(File("hall.json", "{}")));
  EXPECT_EQ(json.size(), 1U);
}

TEST_F(MapFilesTest, WhatIsMissingIsNamed) {
  EXPECT_STATUS(ReadMapFiles(directory_.path() / "none.yaml"), absl::StatusCode::kNotFound, HasSubstr("none.yaml"));
  EXPECT_STATUS(ReadMapFiles(File("hall.yaml", Yaml("gone.pgm"))), absl::StatusCode::kNotFound, HasSubstr("gone.pgm"));
  EXPECT_STATUS(ReadMapFiles(File("hall.yaml", "resolution: 0.05\n")), absl::StatusCode::kInvalidArgument,
                HasSubstr("hall.yaml"));
}

}  // namespace
}  // namespace enfilade::cli
