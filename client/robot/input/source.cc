// SPDX-License-Identifier: Apache-2.0
#include "client/robot/input/source.h"

#include <deque>
#include <utility>

#include "client/robot/input/commands.h"
#include "client/simulator/simulation_files.h"
#include "client/sources/content.h"
#include "client/sources/formats/log_parser.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "io/file.h"
#include "nlohmann/json.hpp"

namespace enfilade::robot {
namespace {

using client::SpoolItem;

constexpr auto kTimeout = std::chrono::milliseconds(100);

absl::StatusOr<SpoolItem> ItemOf(sources::LogEntry entry) {
  SpoolItem item{std::move(entry.payload), {}};
  if (!entry.content.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(item.content, sources::ReadContent(entry.content));
  }
  return item;
}

class LogSource : public Source {
 public:
  explicit LogSource(sources::LogReader reader) : reader_(std::move(reader)) {}

  absl::StatusOr<Input> Next() override {
    ENFILADE_ASSIGN_OR_RETURN(std::optional<sources::LogEntry> entry, reader_.Next());
    if (!entry) return Input(Ended{});
    ENFILADE_ASSIGN_OR_RETURN(SpoolItem item, ItemOf(*std::move(entry)));
    return Input(std::move(item));
  }

 private:
  sources::LogReader reader_;
};

class SimulationSource : public Source {
 public:
  SimulationSource(simulator::RobotSimulation simulation, std::string truth)
      : simulation_(std::move(simulation)), truth_(std::move(truth)) {}

  absl::StatusOr<Input> Next() override {
    if (next_) return Input(*std::exchange(next_, std::nullopt));
    ENFILADE_ASSIGN_OR_RETURN(std::optional<simulator::SimulatedRecord> record, simulation_.Next());
    if (record) {
      SpoolItem item{std::move(record->payload), std::move(record->content)};
      if (simulation_.level() == level_) return Input(std::move(item));
      level_ = simulation_.level();
      next_ = std::move(item);
      return Input(Command(EnterLevel{level_}));  // as a lift tells its passengers
    }
    if (!truth_.empty()) {
      ENFILADE_RETURN_IF_ERROR(io::WriteFile(truth_, simulator::TruthLines(simulation_.truth())));
      truth_.clear();
    }
    return Input(Ended{});
  }

 private:
  simulator::RobotSimulation simulation_;
  std::string truth_;
  int level_ = 0;                  // that the agent knows
  std::optional<SpoolItem> next_;  // recorded on a level that the agent has just been told
};

class LinesSource : public Source {
 public:
  LinesSource(int fd, const std::filesystem::path& folder, const Eigen::Matrix3d& covariance)
      : lines_(fd), parser_(sources::NewJsonLinesParser({}, folder)), covariance_(covariance) {}

  absl::StatusOr<Input> Next() override {
    while (pending_.empty()) {
      absl::StatusOr<std::optional<std::string>> line = lines_.Next(kTimeout);
      if (absl::IsInvalidArgument(line.status())) return Input(BadInput{std::string(line.status().message())});
      if (!line.ok()) return line.status();
      if (!line->has_value()) return lines_.at_end() ? Input(Ended{}) : Input(Idle{});
      const std::string& text = **line;
      const std::size_t first = text.find_first_not_of(" \t\f");
      if (first == std::string::npos || text[first] == '#') continue;
      absl::Status status = Read(text);
      if (!status.ok()) {
        return Input(BadInput{fmt::format("line {}: {}", lines_.line_number(), std::string(status.message()))});
      }
    }
    Input input = std::move(pending_.front());
    pending_.pop_front();
    return input;
  }

 private:
  absl::Status Read(const std::string& text) {
    // Only short lines can be commands or poses: a scan is not parsed twice.
    constexpr std::size_t kLongest = 4096;
    if (text.size() <= kLongest) {
      const nlohmann::json object = nlohmann::json::parse(text, nullptr, false);
      const bool typed = object.is_object() && object.contains("type") && object["type"].is_string();
      if (typed && object["type"] == "command") {
        ENFILADE_ASSIGN_OR_RETURN(Command command, CommandFromJson(object, covariance_));
        pending_.emplace_back(std::move(command));
        return absl::OkStatus();
      }
      if (typed && object["type"] == "pose") return ReadPose(object);
    }
    ENFILADE_ASSIGN_OR_RETURN(sources::ParsedLine parsed, parser_->Parse(text));
    for (sources::LogEntry& entry : parsed.entries) {
      ENFILADE_ASSIGN_OR_RETURN(SpoolItem item, ItemOf(std::move(entry)));
      pending_.emplace_back(std::move(item));
    }
    return absl::OkStatus();
  }

  absl::Status ReadPose(const nlohmann::json& object) {
    PoseReport pose;
    const auto map = object.find("map");
    const auto time = object.find("time_ns");
    if (map == object.end() || !map->is_string()) return InvalidArgument("map is missing or not a text");
    if (time == object.end() || !time->is_number_integer())
      return InvalidArgument("time_ns is missing or not an integer");
    pose.map = map->get<std::string>();
    pose.time = time->get<TimeNs>();
    ENFILADE_ASSIGN_OR_RETURN(pose.T_map_robot.pose, PoseFromJson(object, "pose"));
    ENFILADE_ASSIGN_OR_RETURN(pose.T_map_robot.covariance, CovarianceFromJson(object, covariance_));
    const std::size_t members = object.contains("covariance") ? 5 : 4;
    if (object.size() != members) return InvalidArgument("the pose has unknown members");
    pending_.emplace_back(std::move(pose));
    return absl::OkStatus();
  }

  LineReader lines_;
  std::unique_ptr<sources::LogParser> parser_;
  Eigen::Matrix3d covariance_;
  std::deque<Input> pending_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Source>> OpenLog(const std::string& path, const sources::LogOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(sources::LogReader reader, sources::LogReader::Open(path, options));
  return std::make_unique<LogSource>(std::move(reader));
}

absl::StatusOr<std::unique_ptr<Source>> OpenSimulation(const std::string& campus, const std::string& robot,
                                                       const simulator::SimulationOptions& options, std::string truth) {
  ENFILADE_ASSIGN_OR_RETURN(simulator::Campus loaded, simulator::LoadCampus(campus));
  ENFILADE_ASSIGN_OR_RETURN(
      simulator::RobotSimulation simulation,
      simulator::RobotSimulation::Start(std::make_shared<const simulator::World>(std::move(loaded)), robot, options));
  return std::make_unique<SimulationSource>(std::move(simulation), std::move(truth));
}

std::unique_ptr<Source> OpenLines(int fd, const std::filesystem::path& folder, const Eigen::Matrix3d& covariance) {
  return std::make_unique<LinesSource>(fd, folder, covariance);
}

}  // namespace enfilade::robot
