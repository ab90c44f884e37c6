// SPDX-License-Identifier: Apache-2.0
#include "client/robot/input/commands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/status_assertions.h"

namespace enfilade::robot {
namespace {

using ::testing::HasSubstr;

const Eigen::Matrix3d kCovariance = Eigen::Vector3d(1.0, 2.0, 3.0).asDiagonal();

template <typename T>
T Parsed(const std::string& line) {
  const absl::StatusOr<Command> command = ParseCommand(line, kCovariance);
  EXPECT_OK(command.status()) << line;
  if (!command.ok() || !std::holds_alternative<T>(*command)) {
    ADD_FAILURE() << line;
    return {};
  }
  return std::get<T>(*command);
}

TEST(ParseCommand, ReadsEveryCommand) {
  EXPECT_EQ(Parsed<SetLinkPoint>("set-link-point").place, graph::LinkPointKind::kDoor);
  const auto lift = Parsed<SetLinkPoint>("  set_link_point lift -2 ");
  EXPECT_EQ(lift.place, graph::LinkPointKind::kLift);
  EXPECT_EQ(lift.level, -2);
  EXPECT_EQ(Parsed<SetCandidate>("set-candidate stairs").place, graph::LinkPointKind::kStairs);
  EXPECT_EQ(Parsed<RecordNewMap>("new").map, "");
  EXPECT_EQ(Parsed<RecordNewMap>("new \"Hall A\"").map, "Hall A");
  EXPECT_EQ(Parsed<DeleteMap>("delete-map m1").map, "m1");
  EXPECT_EQ(Parsed<DeleteLinkPoint>("delete-link-point l1").link_point, "l1");
  EXPECT_EQ(Parsed<EnterLevel>("level -1").level, -1);
  Parsed<SaveRearImage>("save-rear-image");
  Parsed<StopMapping>("stop");
  Parsed<Abort>("abort\r");
  Parsed<AskStatus>("status");
}

TEST(ParseCommand, AcceptsTheNamesOfMapManagersServices) {
  Parsed<SetLinkPoint>("set_linkpoint");
  Parsed<SaveRearImage>("save_linkpoint_rear_img");
  Parsed<SetCandidate>("set_linkpoint_candidate");
}

TEST(ParseCommand, ReadsThePoseInAnExistingMapInDegrees) {
  const auto old = Parsed<MapOnExistingMap>("old \"Hall A\" 1.5 -2 90");
  EXPECT_EQ(old.map, "Hall A");
  EXPECT_EQ(old.T_map_robot.pose.x, 1.5);
  EXPECT_EQ(old.T_map_robot.pose.y, -2.0);
  EXPECT_NEAR(old.T_map_robot.pose.yaw, M_PI / 2.0, 1e-12);
  EXPECT_EQ(old.T_map_robot.covariance, kCovariance);
}

TEST(ParseCommand, RefusesWhatItCannotRead) {
  for (const auto& [line, message] :
       {std::pair("", "there is no command"), std::pair("drive", "not a command; the commands are"),
        std::pair("old Hall", "where in the map"), std::pair("old", "which map"),
        std::pair("old Hall 1 2 x", "not a number"), std::pair("old Hall 1 2 nan", "not finite"),
        std::pair("set-link-point window", "place is"), std::pair("set-link-point lift up", "not a number"),
        std::pair("level", "which level"), std::pair("level up", "not a number"), std::pair("stop now", "too many"),
        std::pair("new \"Hall", "quotation mark"), std::pair("delete-link-point", "which link point")}) {
    EXPECT_STATUS(ParseCommand(line, kCovariance).status(), absl::StatusCode::kInvalidArgument, HasSubstr(message))
        << line;
  }
}

TEST(CommandFromJson, ReadsTheSameCommands) {
  const auto read = [](const char* text) { return CommandFromJson(nlohmann::json::parse(text), kCovariance); };
  ASSERT_OK_AND_ASSIGN(const Command lift,
                       read(R"({"type":"command","command":"set_linkpoint","place":"lift","level":3})"));
  EXPECT_EQ(std::get<SetLinkPoint>(lift).level, 3);
  ASSERT_OK_AND_ASSIGN(const Command old, read(R"({"type":"command","command":"old","map":"m","pose":
      {"x_m":1,"y_m":2,"yaw_rad":0.5},"covariance":[4,0,0,0,5,0,0,0,6]})"));
  EXPECT_EQ(std::get<MapOnExistingMap>(old).T_map_robot.pose.yaw, 0.5);
  EXPECT_EQ(std::get<MapOnExistingMap>(old).T_map_robot.covariance(1, 1), 5.0);
}

TEST(CommandFromJson, RefusesWhatItCannotRead) {
  for (const char* text :
       {R"({"command":1})", R"({"command":"stop","now":true})", R"({"command":"new","map":3})", R"({})",
        R"({"command":"set-link-point","level":"up"})", R"({"command":"old","map":"m","pose":{"x_m":1,"y_m":2}})",
        R"({"command":"old","map":"m","pose":{"x_m":1,"y_m":2,"yaw_rad":0},"covariance":[1]})"}) {
    EXPECT_CODE(CommandFromJson(nlohmann::json::parse(text), kCovariance).status(), absl::StatusCode::kInvalidArgument)
        << text;
  }
}

TEST(ParseCommand, ReadsOldAndExistingAsOneCommand) {
  for (const char* word : {"old", "existing"}) {
    const auto existing = Parsed<MapOnExistingMap>(std::string(word) + " m1 0 0 -270");
    EXPECT_EQ(existing.map, "m1");
    EXPECT_NEAR(existing.T_map_robot.pose.yaw, M_PI / 2.0, 1e-12) << "the yaw is wrapped";
  }
}

// Each line of the help is a command that parses once its arguments are filled in.
TEST(CommandHelp, NamesEveryCommandWithItsArguments) {
  const std::string help = CommandHelp();
  const std::pair<const char*, const char*> samples[] = {{"PLACE", "ramp"},   {"LEVEL", "3"}, {"NAME", "x"},
                                                         {"LINK_POINT", "l"}, {"MAP", "m"},   {"X Y YAW", "1 2 3"}};
  int commands = 0;
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = help.find('\n', begin)) != std::string::npos; begin = end + 1) {
    const std::string line = help.substr(begin, end - begin);
    std::string command = line.substr(2, line.find("  ", 2) - 2);
    std::erase_if(command, [](char c) { return c == '[' || c == ']'; });
    for (const auto& [name, sample] : samples) {
      const std::size_t at = command.find(name);
      if (at != std::string::npos) command.replace(at, std::string(name).size(), sample);
    }
    EXPECT_OK(ParseCommand(command, kCovariance)) << command;
    ++commands;
  }
  EXPECT_EQ(commands, 11);
}

TEST(CommandFromJson, RefusesNumbersThatDoNotFit) {
  for (const char* text :
       {R"({"command":"set-link-point","level":1e10})", R"({"command":"set-link-point","level":4294967296})",
        R"({"command":"set-link-point","level":1.5})"}) {
    EXPECT_STATUS(CommandFromJson(nlohmann::json::parse(text), kCovariance), absl::StatusCode::kInvalidArgument,
                  HasSubstr("level"))
        << text;
  }
}

TEST(CommandFromJson, CannotCrashOnAnyOfItsMembers) {
  const char* const values[] = {
      "null", "true", "-1", "1.5", "\"x\"", "[]", "[1,2,3,4,5,6,7,8,9]", "{}", R"({"x_m":1,"y_m":2,"yaw_rad":3})"};
  for (const char* command : {"set-link-point", "existing", "new", "delete-map", "delete-link-point", "status"}) {
    for (const char* member : {"place", "level", "map", "link_point", "pose", "covariance", "type", "command", "x"}) {
      for (const char* value : values) {
        const std::string text = std::string(R"({"command":")") + command + R"(",")" + member + R"(":)" + value + "}";
        const absl::StatusOr<Command> parsed = CommandFromJson(nlohmann::json::parse(text), kCovariance);
        if (!parsed.ok()) {
          EXPECT_CODE(parsed.status(), absl::StatusCode::kInvalidArgument) << text;
        }
      }
    }
  }
}

}  // namespace
}  // namespace enfilade::robot
