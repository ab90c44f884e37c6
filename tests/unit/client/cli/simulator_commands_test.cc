// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "client/cli/commands/commands.h"
#include "core/grid/files/png_codec.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/client/cli/command_test.h"

namespace enfilade::cli {
namespace {

using ::testing::HasSubstr;

class SimulatorCommandsTest : public CommandTest {
 protected:
  absl::Status Run(std::vector<std::string> arguments) {
    const auto add = [](CLI::App& app, const Globals& globals) {
      AddSimulate(app, globals);
      AddDoors(app, globals);
    };
    return RunCommandLine(add, std::move(arguments), true);
  }
  // Drives robot r1 through the campus "figure1".
  absl::Status Drive(const std::filesystem::path& folder, const std::string& seed) {
    return Run({"simulate", "figure1", "-o", folder, "--robots", "r1", "--seed", seed});
  }
  static std::vector<nlohmann::json> Lines(const std::string& text) {
    std::vector<nlohmann::json> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(nlohmann::json::parse(line));
    return lines;
  }

  const std::filesystem::path out_ = directory_.path() / "campus";
};

TEST_F(SimulatorCommandsTest, SimulateWritesLogTruthAndPlan) {
  ASSERT_OK(Drive(out_, "1"));
  const nlohmann::json drives = nlohmann::json::parse(printed_)["drives"];
  ASSERT_EQ(drives.size(), 1U);
  EXPECT_EQ(drives[0]["robot"], "r1");
  EXPECT_GT(drives[0]["scans"], 100);
  EXPECT_GE(drives[0]["passages"], 5) << "the figure's five link points";
  EXPECT_FALSE(Lines(Content(out_ / "r1/truth.jsonl")).empty());
  EXPECT_OK(grid::DecodePng(Content(out_ / "plan.png")).status());
}

TEST_F(SimulatorCommandsTest, SimulateGivesTheSameLogForTheSameSeedOnly) {
  ASSERT_OK(Drive(out_ / "a", "1"));
  ASSERT_OK(Drive(out_ / "b", "1"));
  ASSERT_OK(Drive(out_ / "c", "2"));
  const std::string log = Content(out_ / "a/r1/log.jsonl");
  EXPECT_FALSE(log.empty());
  EXPECT_TRUE(log == Content(out_ / "b/r1/log.jsonl"));
  EXPECT_FALSE(log == Content(out_ / "c/r1/log.jsonl"));
}

TEST_F(SimulatorCommandsTest, SimulateNamesWhatItDoesNotKnow) {
  EXPECT_STATUS(Run({"simulate", "figure1", "-o", out_, "--robots", "r9"}), absl::StatusCode::kNotFound,
                HasSubstr("r9"));
  EXPECT_STATUS(Run({"simulate", File("bad.yaml", "walls: 7\n"), "-o", out_}), absl::StatusCode::kInvalidArgument,
                HasSubstr("bad.yaml"));
}

TEST_F(SimulatorCommandsTest, WithoutACampusOneLogIsWrittenWithTheScannerOfTheRooms) {
  const std::string log = directory_.path() / "drive.jsonl";
  const std::string truth = directory_.path() / "truth.txt";
  ASSERT_OK(Run({"simulate", "-o", log, "--truth", truth, "--laps", "1", "--seed", "3"}));
  const nlohmann::json document = nlohmann::json::parse(printed_);
  EXPECT_EQ(document["log"], log);
  const std::string poses = Content(truth);
  EXPECT_EQ(document["scans"], std::count(poses.begin(), poses.end(), '\n'));
  int scans = 0;
  for (const nlohmann::json& line : Lines(Content(log))) {
    if (!line.contains("ranges_m")) continue;
    ++scans;
    ASSERT_EQ(line["ranges_m"].size(), 361U) << "270 degrees, not the full turn of a campus";
  }
  EXPECT_EQ(scans, document["scans"]);
  const std::string first = Content(log);
  ASSERT_OK(Run({"sim", "-o", log, "--laps", "1", "--seed", "3"})) << "the former name";
  EXPECT_TRUE(Content(log) == first);
  ASSERT_OK(Run({"simulate", "-o", log, "--laps", "1", "--seed", "3", "--beams", "90"}));
  EXPECT_FALSE(Content(log) == first);
}

TEST_F(SimulatorCommandsTest, WhatOnlyOneFormOfSimulateHasIsRefusedByTheOther) {
  const std::string log = directory_.path() / "drive.jsonl";
  constexpr auto kBad = absl::StatusCode::kInvalidArgument;
  EXPECT_STATUS(Run({"simulate", "-o", log, "--robots", "r1"}), kBad, HasSubstr("--robots"));
  for (const char* sensor : {"--image-hz", "--depth-hz", "--cloud-hz"}) {
    EXPECT_STATUS(Run({"simulate", "-o", log, sensor, "1"}), kBad, HasSubstr("CAMPUS")) << sensor;
  }
  EXPECT_STATUS(Run({"simulate", "figure1", "-o", out_, "--truth", log}), kBad, HasSubstr("truth.txt"));
  EXPECT_STATUS(Run({"simulate", "-o", log, "--laps", "0"}), kBad, HasSubstr("laps is 0"));
  EXPECT_CODE(Run({"simulate", "figure1"}), kBad) << "without -o";
  EXPECT_FALSE(std::filesystem::exists(log));
  EXPECT_FALSE(std::filesystem::exists(out_));
}

TEST_F(SimulatorCommandsTest, DoorsReportsEventsAsJsonLinesAndDrawsThem) {
  ASSERT_OK(Drive(out_, "1"));
  const std::string plot = directory_.path() / "doors.png";
  ASSERT_OK(Run({"doors", out_ / "r1/log.jsonl", "--plot", plot}));
  int passages = 0;
  for (const nlohmann::json& event : Lines(printed_)) {
    passages += event["event"] == "passage" ? 1 : 0;
    for (const char* criterion : {"ahead", "behind", "environment"}) EXPECT_FALSE(event[criterion]["reason"].empty());
  }
  EXPECT_GT(passages, 0);
  EXPECT_OK(grid::DecodePng(Content(plot)).status());
}

TEST_F(SimulatorCommandsTest, DoorsRefusesUnknownPresetsOptionsAndLogs) {
  const std::string log = File("empty.jsonl", "");
  EXPECT_STATUS(Run({"doors", log, "--preset", "best"}), absl::StatusCode::kInvalidArgument, HasSubstr("best"));
  EXPECT_STATUS(Run({"doors", log, "--options", File("doors.yaml", "no_such_key: 1\n")}),
                absl::StatusCode::kInvalidArgument, HasSubstr("no_such_key"));
  EXPECT_FALSE(Run({"doors", log}).ok()) << "an empty log";
  EXPECT_STATUS(Run({"doors", "/nowhere/log.clf"}), absl::StatusCode::kNotFound, HasSubstr("log.clf"));
}

}  // namespace
}  // namespace enfilade::cli
