// SPDX-License-Identifier: Apache-2.0
// A robot that is killed and restarted elsewhere, where nobody tells it where it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "client/simulator/simulation.h"
#include "client/simulator/simulation_files.h"
#include "fmt/format.h"
#include "tests/e2e/campus/comparison.h"
#include "tests/e2e/campus/drive_truth.h"
#include "tests/e2e/campus/json_lines.h"
#include "tests/e2e/campus/mapped_state.h"
#include "tests/e2e/whole_system.h"
#include "tests/support/slowdown.h"

namespace enfilade::testing {
namespace {

using nlohmann::json;

constexpr const char* kCampus = "random:8002";
constexpr const char* kRobot = "robot";
constexpr int kLaps = 2;

class RestartTest : public ::testing::Test {
 protected:
  RestartTest() : system_({"mapping.lease_s=1"}) { system_.CreateSite("s"); }

  std::unique_ptr<Process> StartRobot(const std::vector<std::string>& arguments, const std::string& output) {
    std::vector<std::string> command = {Program("enfilade"),
                                        "--json",
                                        "--server",
                                        system_.server().address(),
                                        "--site",
                                        "s",
                                        "robot",
                                        "--robot",
                                        kRobot,
                                        "--spool",
                                        (system_.directory() / "robot.spool").string(),
                                        "--campus",
                                        kCampus,
                                        "--laps",
                                        std::to_string(kLaps),
                                        "--image-hz",
                                        "0",
                                        "--cloud-hz",
                                        "0"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return std::make_unique<Process>(command, system_.directory() / output);
  }
  std::vector<json> EventsOf(const std::string& output, const std::string& event) {
    std::vector<json> events;
    for (json& line : ReadJsonLines(system_.directory() / output)) {
      if (line.value("event", "") == event) events.push_back(std::move(line));
    }
    return events;
  }
  // The latest record that the server has; 0: none.
  TimeNs LastRecord(TimeNs before = std::numeric_limits<TimeNs>::max()) {
    return std::stoll(system_.Query(
        fmt::format("SELECT coalesce(max(last_time_ns), 0) FROM sessions WHERE last_time_ns < {}", before)));
  }

  // The robot drives, is killed (kill -9) in its first round, and is restarted later, in its second one. Its maps are
  // compared with the truth.
  Comparison RestartElsewhere(const std::vector<std::string>& arguments) {
    const auto drive = simulator::SimulateDrive(world_, kRobot, options_);
    if (!drive.ok()) throw std::runtime_error(std::string(drive.status().message()));
    const double whole_s = ToSeconds(drive->truth.poses.back().time - options_.start_time);
    const auto killed = StartRobot({"--rate", "40"}, "1.jsonl");
    const TimeNs enough = options_.start_time + std::llround(0.45 * whole_s * 1e9);
    if (!Eventually([&] { return LastRecord() > enough || !killed->running(); }) || !killed->running()) {
      throw std::runtime_error("the first run: " + TailOf(system_.directory() / "1.jsonl"));
    }
    killed->Kill();
    const double restart_s = std::round(0.6 * whole_s);
    std::vector<std::string> restart = {"--wait", "--start-after", fmt::format("{}", restart_s)};
    restart.insert(restart.end(), arguments.begin(), arguments.end());
    if (StartRobot(restart, "2.jsonl")->Wait(std::chrono::minutes(10 * kSlowdown)) != 0) {
      throw std::runtime_error("the second run: " + TailOf(system_.directory() / "2.jsonl"));
    }
    const TimeNs restarted = options_.start_time + std::llround(restart_s * 1e9);
    const MappedState state = ReadWhenQuiet(system_.server().Connect(), "s", {kRobot});
    return Compare({TruthOf(drive->truth, LastRecord(restarted), restarted)}, DoorsOf(world_->campus()), state);
  }
  // Where the robot was while it recorded: until it was killed, and after it was restarted.
  DriveTruth TruthOf(const simulator::GroundTruth& whole, TimeNs killed, TimeNs restarted) {
    const std::filesystem::path file = system_.directory() / "truth.jsonl";
    std::ofstream(file) << simulator::TruthLines(whole);
    DriveTruth truth = ReadTruth(kRobot, file);
    const auto between = [&](const auto& one) { return one.time > killed && one.time < restarted; };
    std::erase_if(truth.poses, between);
    std::erase_if(truth.passages, between);
    return truth;
  }
  static void ExpectNoAreaTwice(const Comparison& comparison) {
    const std::string wrong = ::testing::PrintToString(comparison.wrong);
    EXPECT_GE(comparison.areas, 5) << "the robot was in several areas";
    EXPECT_EQ(comparison.areas_doubled, 0) << wrong;
    EXPECT_EQ(comparison.maps_extra, 0) << wrong;
    EXPECT_EQ(comparison.components, 1) << wrong;
    EXPECT_EQ(comparison.false_placements, 0) << wrong;
    EXPECT_LT(comparison.position_max, 0.6);
    EXPECT_EQ(comparison.unplaced_s, 0.0);
  }

  static simulator::SimulationOptions Laps() {
    simulator::SimulationOptions options;
    options.laps = kLaps;
    return options;
  }

  const simulator::SimulationOptions options_ = Laps();
  const std::shared_ptr<const simulator::World> world_ =
      std::make_shared<const simulator::World>(*simulator::LoadCampus(kCampus));
  WholeSystem system_;
};

TEST_F(RestartTest, ARobotFindsItselfAndMapsNoAreaTwice) {
  ExpectNoAreaTwice(RestartElsewhere({}));
  const std::vector<json> leftover = EventsOf("2.jsonl", "leftover");
  ASSERT_EQ(leftover.size(), 1U);
  EXPECT_TRUE(leftover[0].at("left_open"));
  const std::vector<json> located = EventsOf("2.jsonl", "located");
  ASSERT_EQ(located.size(), 1U);
  EXPECT_TRUE(located[0].at("map").is_string()) << located[0];
}

// It is told to begin a new map. That nothing joins it to the others, the survey mends.
TEST_F(RestartTest, AMapThatARobotBeginsInKnownRoomsIsJoined) {
  ExpectNoAreaTwice(RestartElsewhere({"--map", "Elsewhere"}));
  EXPECT_TRUE(EventsOf("2.jsonl", "located").empty());
}

}  // namespace
}  // namespace enfilade::testing
