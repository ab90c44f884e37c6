// SPDX-License-Identifier: Apache-2.0
#include "client/robot/input/commands.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/geometry/pose2.h"

namespace enfilade::robot {
namespace {

constexpr const char* kHelp =
    "  set-link-point [PLACE [LEVEL]]  the robot has left the map here: door, lift, stairs, ramp or opening\n"
    "  save-rear-image                 before a door: keep this view for the next link point or candidate\n"
    "  set-candidate [PLACE]           there is a door ahead that the robot will not drive through now\n"
    "  level LEVEL                     the robot has come to this level, for example in a lift\n"
    "  stop                            finish this map and return to the main menu\n"
    "  status\n"
    "  new [NAME]                      main menu: record a new map\n"
    "  existing MAP X Y YAW            main menu: continue an existing map from this pose in it (m, degrees); also: "
    "old\n"
    "  delete-map MAP                  main menu\n"
    "  delete-link-point LINK_POINT    main menu\n"
    "  abort                           finish the open session and exit\n";

// Arguments by name, from a typed line or from JSON.
struct Arguments {
  std::string word;
  std::string map;
  std::string link_point;
  std::string place;
  std::optional<std::int32_t> level;
  std::optional<Pose2> pose;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

absl::StatusOr<graph::LinkPointKind> PlaceOf(const std::string& text) {
  if (text.empty() || text == "door") return graph::LinkPointKind::kDoor;
  if (text == "lift") return graph::LinkPointKind::kLift;
  if (text == "stairs") return graph::LinkPointKind::kStairs;
  if (text == "ramp") return graph::LinkPointKind::kRamp;
  if (text == "opening") return graph::LinkPointKind::kOpening;
  return InvalidArgument("place is \"{}\": expected door, lift, stairs, ramp or opening", text);
}

// Aliases, among them the names of map_manager's services.
std::string CanonicalWord(std::string word) {
  for (char& c : word) c = c == '_' ? '-' : c;
  if (word == "old") return "existing";
  if (word == "set-linkpoint") return "set-link-point";
  if (word == "save-linkpoint-rear-img") return "save-rear-image";
  if (word == "set-linkpoint-candidate") return "set-candidate";
  return word;
}

absl::StatusOr<Command> CommandOf(const Arguments& arguments) {
  const std::string& word = arguments.word;
  ENFILADE_ASSIGN_OR_RETURN(const graph::LinkPointKind place, PlaceOf(arguments.place));
  if (word == "set-link-point") return Command(SetLinkPoint{place, arguments.level});
  if (word == "save-rear-image") return Command(SaveRearImage{});
  if (word == "set-candidate") return Command(SetCandidate{place});
  if (word == "level") {
    if (!arguments.level) return InvalidArgument("level: which level? Expected level NUMBER");
    return Command(EnterLevel{*arguments.level});
  }
  if (word == "new") return Command(RecordNewMap{arguments.map});
  if (word == "stop") return Command(StopMapping{});
  if (word == "abort") return Command(Abort{});
  if (word == "status") return Command(AskStatus{});
  if (word == "delete-link-point") {
    if (arguments.link_point.empty()) return InvalidArgument("{}: which link point?", word);
    return Command(DeleteLinkPoint{arguments.link_point});
  }
  if (word != "existing" && word != "delete-map") {
    return InvalidArgument("\"{}\" is not a command; the commands are\n{}", word.substr(0, 40), kHelp);
  }
  if (arguments.map.empty()) return InvalidArgument("{}: which map?", word);
  if (word == "delete-map") return Command(DeleteMap{arguments.map});
  if (!arguments.pose) return InvalidArgument("existing: where in the map is the robot? Expected existing MAP X Y YAW");
  return Command(MapOnExistingMap{arguments.map, {*arguments.pose, arguments.covariance}});
}

// Splits at blanks; "a text in quotes" is one word.
absl::StatusOr<std::vector<std::string>> WordsOf(std::string_view line) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < line.size();) {
    if (line[i] == ' ' || line[i] == '\t' || line[i] == '\r') {
      ++i;
      continue;
    }
    const bool quoted = line[i] == '"';
    const std::size_t begin = quoted ? i + 1 : i;
    const std::size_t end = line.find_first_of(quoted ? "\"" : " \t\r", begin);
    if (quoted && end == std::string_view::npos) return InvalidArgument("a quotation mark is not closed");
    words.emplace_back(line.substr(begin, std::min(end, line.size()) - begin));
    i = std::min(end, line.size() - 1) + 1;
  }
  return words;
}

template <typename T>
absl::StatusOr<T> NumberOf(const std::string& text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    return InvalidArgument("\"{}\" is not a number of the expected kind", text.substr(0, 40));
  }
  return value;
}

}  // namespace

absl::StatusOr<Command> ParseCommand(std::string_view line, const Eigen::Matrix3d& covariance) {
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<std::string> words, WordsOf(line));
  if (words.empty()) return InvalidArgument("there is no command");
  Arguments arguments;
  arguments.word = CanonicalWord(words[0]);
  arguments.covariance = covariance;
  const bool place = arguments.word == "set-link-point" || arguments.word == "set-candidate";
  std::size_t taken = 1;
  if (words.size() > taken && place) {
    arguments.place = words[taken++];
    if (words.size() > taken && arguments.word == "set-link-point") {
      ENFILADE_ASSIGN_OR_RETURN(arguments.level, NumberOf<std::int32_t>(words[taken++]));
    }
  } else if (words.size() > taken && arguments.word == "level") {
    ENFILADE_ASSIGN_OR_RETURN(arguments.level, NumberOf<std::int32_t>(words[taken++]));
  } else if (words.size() > taken && arguments.word == "delete-link-point") {
    arguments.link_point = words[taken++];
  } else if (words.size() > taken &&
             (arguments.word == "new" || arguments.word == "existing" || arguments.word == "delete-map")) {
    arguments.map = words[taken++];
  }
  if (arguments.word == "existing" && words.size() >= taken + 3) {
    Pose2 pose;
    ENFILADE_ASSIGN_OR_RETURN(pose.x, NumberOf<double>(words[taken++]));
    ENFILADE_ASSIGN_OR_RETURN(pose.y, NumberOf<double>(words[taken++]));
    ENFILADE_ASSIGN_OR_RETURN(pose.yaw, NumberOf<double>(words[taken++]));
    pose.yaw = WrapAngle(pose.yaw * kDegree);
    if (!IsFinite(pose)) return InvalidArgument("existing: the pose is not finite");
    arguments.pose = pose;
  }
  ENFILADE_ASSIGN_OR_RETURN(Command command, CommandOf(arguments));
  if (taken < words.size())
    return InvalidArgument("{}: \"{}\" is one argument too many", words[0], words[taken].substr(0, 40));
  return command;
}

absl::StatusOr<Pose2> PoseFromJson(const nlohmann::json& object, const std::string& name) {
  const auto pose = object.find(name);
  if (pose == object.end() || !pose->is_object()) return InvalidArgument("{} is missing", name);
  double values[3] = {};
  constexpr std::array<const char*, 3> kNames = {"x_m", "y_m", "yaw_rad"};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const auto value = pose->find(kNames[i]);
    if (value == pose->end() || !value->is_number()) {
      return InvalidArgument("{}.{} is missing or not a number", name, kNames[i]);
    }
    values[i] = value->get<double>();
  }
  if (pose->size() != kNames.size()) return InvalidArgument("{} has unknown members", name);
  return Pose2{values[0], values[1], WrapAngle(values[2])};
}

absl::StatusOr<Eigen::Matrix3d> CovarianceFromJson(const nlohmann::json& object, const Eigen::Matrix3d& otherwise) {
  const auto member = object.find("covariance");
  if (member == object.end()) return otherwise;
  if (!member->is_array() || member->size() != 9) return InvalidArgument("covariance: expected 9 numbers");
  Eigen::Matrix3d covariance;
  for (Eigen::Index i = 0; i < 9; ++i) {
    const nlohmann::json& value = (*member)[static_cast<std::size_t>(i)];
    if (!value.is_number()) return InvalidArgument("covariance: expected 9 numbers");
    covariance(i / 3, i % 3) = value.get<double>();
  }
  return covariance;
}

absl::StatusOr<Command> CommandFromJson(const nlohmann::json& object, const Eigen::Matrix3d& covariance) {
  Arguments arguments;
  for (const auto& [name, value] : object.items()) {
    std::string* const text = name == "command"      ? &arguments.word
                              : name == "map"        ? &arguments.map
                              : name == "link_point" ? &arguments.link_point
                              : name == "place"      ? &arguments.place
                                                     : nullptr;
    if (text) {
      if (!value.is_string()) return InvalidArgument("{} is not a text", name);
      *text = value.get<std::string>();
    } else if (name == "level") {
      constexpr std::int64_t kMaxLevel = std::numeric_limits<std::int32_t>::max();
      if (!value.is_number_integer() || std::abs(value.get<double>()) > static_cast<double>(kMaxLevel)) {
        return InvalidArgument("level is not an integer of 32 bits");
      }
      arguments.level = value.get<std::int32_t>();
    } else if (name == "pose") {
      ENFILADE_ASSIGN_OR_RETURN(arguments.pose, PoseFromJson(object, "pose"));
    } else if (name != "type" && name != "covariance") {
      return InvalidArgument("a command has no member {}", name.substr(0, 40));
    }
  }
  arguments.word = CanonicalWord(arguments.word);
  ENFILADE_ASSIGN_OR_RETURN(arguments.covariance, CovarianceFromJson(object, covariance));
  return CommandOf(arguments);
}

std::string CommandHelp() { return kHelp; }

}  // namespace enfilade::robot
