// SPDX-License-Identifier: Apache-2.0
// A robot's agent and a real server that is down in the middle of the drive.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "nlohmann/json.hpp"
#include "tests/e2e/whole_system.h"

namespace enfilade::testing {
namespace {

using nlohmann::json;

class RobotTest : public ::testing::Test {
 protected:
  RobotTest() : system_({"mapping.lease_s=1"}) { system_.CreateSite("s"); }

  std::unique_ptr<Process> StartRobot(const std::vector<std::string>& arguments, const std::string& output) {
    std::vector<std::string> command = {Program("enfilade"),
                                        "--json",
                                        "--server",
                                        system_.server().address(),
                                        "--site",
                                        "s",
                                        "robot",
                                        "--robot",
                                        "robot",
                                        "--spool",
                                        (system_.directory() / "robot.spool").string()};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return std::make_unique<Process>(command, system_.directory() / output);
  }
  // The events of that name.
  std::vector<json> EventsOf(const std::string& output, const std::string& event) {
    std::vector<json> events;
    std::ifstream in(system_.directory() / output);
    for (std::string line; std::getline(in, line);) {
      json object = json::parse(line, nullptr, false);
      if (object.is_object() && object.value("event", "") == event) events.push_back(std::move(object));
    }
    return events;
  }
  static bool IsBegun(const std::vector<json>& begun, const std::string& session) {
    return std::any_of(begun.begin(), begun.end(), [&](const json& event) { return event.at("session") == session; });
  }
  std::int64_t Number(const std::string& sql) { return std::stoll(system_.Query(sql)); }

  WholeSystem system_;
};

TEST_F(RobotTest, LosesNothingWhileTheServerIsDownAndChainsItsSessions) {
  const auto robot = StartRobot(
      {"--campus", "rooms", "--rate", "15", "--image-hz", "0", "--cloud-hz", "0", "--map", "Rooms", "--wait"},
      "robot.jsonl");
  ASSERT_TRUE(Eventually([&] { return system_.AcknowledgedSequence("s") > 100; }))
      << TailOf(system_.directory() / "robot.jsonl");
  system_.server().Kill();
  // Meanwhile it passes a door.
  const std::size_t sessions = EventsOf("robot.jsonl", "session").size();
  ASSERT_TRUE(Eventually([&] { return EventsOf("robot.jsonl", "session").size() > sessions || !robot->running(); }));
  EXPECT_TRUE(robot->running());
  system_.server().StartAndWait();
  ASSERT_EQ(robot->Wait(std::chrono::minutes(5)), 0) << TailOf(system_.directory() / "robot.jsonl");

  const std::vector<json> begun = EventsOf("robot.jsonl", "session");
  const std::vector<json> end = EventsOf("robot.jsonl", "end");
  ASSERT_EQ(end.size(), 1U);
  EXPECT_GE(begun.size(), 2U) << "the campus has doors";
  EXPECT_EQ(Number("SELECT count(*) FROM session_records"), end[0].at("records").get<std::int64_t>());
  EXPECT_EQ(Number("SELECT count(*) FROM sessions WHERE cut_from_session_id IS NULL"),
            static_cast<std::int64_t>(begun.size()));
  EXPECT_EQ(Number("SELECT count(*) FROM sessions WHERE state <> 3"), 0) << "mapped";
  EXPECT_EQ(system_.Query("SELECT environment FROM maps WHERE display_name = 'Rooms'"), "1");
  // Each session follows the one before, if need be by way of the pieces that a survey has cut from it.
  for (std::size_t i = begun.size() - 1; i > 0; --i) {
    const std::string before = begun[i - 1].at("session").get<std::string>();
    std::string id = begun[i].at("session").get<std::string>();
    do {
      id = system_.Query("SELECT previous_session_id FROM sessions WHERE session_id = '" + id + "'");
    } while (!id.empty() && id != before && !IsBegun(begun, id));
    EXPECT_EQ(id, before);
  }
}

TEST_F(RobotTest, UploadsWhatAKilledRunLeftAndContinuesInAnotherSession) {
  const auto killed = StartRobot({"--campus", "rooms", "--rate", "5", "--image-hz", "0", "--cloud-hz", "0"}, "1.jsonl");
  ASSERT_TRUE(Eventually([&] { return system_.AcknowledgedSequence("s") > 0; }))
      << TailOf(system_.directory() / "1.jsonl");
  killed->Kill();
  const std::int64_t acknowledged = system_.AcknowledgedSequence("s");
  const auto next = StartRobot({"--campus", "rooms", "--image-hz", "0", "--cloud-hz", "0", "--wait"}, "2.jsonl");
  ASSERT_EQ(next->Wait(std::chrono::minutes(5)), 0) << TailOf(system_.directory() / "2.jsonl");
  const std::vector<json> leftover = EventsOf("2.jsonl", "leftover");
  ASSERT_EQ(leftover.size(), 1U);
  EXPECT_TRUE(leftover[0].at("left_open"));
  const std::string session = leftover[0].at("session");
  EXPECT_GE(Number("SELECT acknowledged_sequence FROM sessions WHERE session_id = '" + session + "'"), acknowledged);
  EXPECT_EQ(system_.Query("SELECT state FROM sessions WHERE session_id = '" + session + "'"), "3");
}

TEST_F(RobotTest, ReportsThatItBeginsOutdoors) {
  const std::filesystem::path options = system_.directory() / "robot.yaml";
  std::ofstream(options) << "range_thr: 0.5\n";  // every room is larger
  const auto robot = StartRobot({"--campus", "rooms", "--laps", "1", "--image-hz", "0", "--cloud-hz", "0", "--map",
                                 "Yard", "--options", options.string()},
                                "robot.jsonl");
  ASSERT_EQ(robot->Wait(std::chrono::minutes(5)), 0) << TailOf(system_.directory() / "robot.jsonl");
  EXPECT_EQ(system_.Query("SELECT environment FROM maps WHERE display_name = 'Yard'"), "2");
}

TEST_F(RobotTest, SaysWhyTheServerRefusesASession) {
  const auto robot = StartRobot(
      {"--campus", "rooms", "--laps", "1", "--image-hz", "0", "--cloud-hz", "0", "--on-old-map", "Nowhere,0,0,0"},
      "robot.jsonl");
  const std::optional<int> code = robot->Wait(std::chrono::minutes(5));
  ASSERT_TRUE(code.has_value());
  EXPECT_NE(*code, 0);
  EXPECT_EQ(EventsOf("robot.jsonl", "blocked").size(), 1U) << TailOf(system_.directory() / "robot.jsonl");
}

}  // namespace
}  // namespace enfilade::testing
