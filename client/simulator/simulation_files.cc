// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/simulation_files.h"

#include <charconv>
#include <fstream>
#include <system_error>
#include <utility>

#include "client/simulator/campus/building_campus.h"
#include "client/simulator/campus/campus_yaml.h"
#include "client/simulator/campus/random_building.h"
#include "client/simulator/campus/random_halls.h"
#include "client/simulator/campus/random_suites.h"
#include "client/simulator/campus/shipped_campuses.h"
#include "client/sources/formats/json_lines_writer.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/prior/formats/building_file.h"
#include "io/file.h"
#include "nlohmann/json.hpp"

namespace enfilade::simulator {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBuildingSuffix = ".building.yaml";

absl::Status MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) return absl::OkStatus();
  return FailedPrecondition("{}: the folder cannot be created: {}", folder.string(), error.message());
}

absl::Status CannotWrite(const fs::path& path) {
  return FailedPrecondition("{}: cannot be written (no such folder, no permission, or the disk is full)",
                            path.string());
}

nlohmann::json PoseJson(const Pose2& pose) { return {{"x_m", pose.x}, {"y_m", pose.y}, {"yaw_rad", pose.yaw}}; }

class DriveWriter {
 public:
  DriveWriter(fs::path folder, DriveReport& report) : folder_(std::move(folder)), report_(report) {}

  absl::Status Open() {
    ENFILADE_RETURN_IF_ERROR(MakeFolder(folder_));
    report_.log = folder_ / "log.jsonl";
    log_.open(report_.log, std::ios::binary);
    log_ << sources::JsonLinesHeader();
    return absl::OkStatus();
  }
  absl::Status Add(const SimulatedRecord& record) {
    sources::LogEntry entry{record.payload, {}};
    if (std::holds_alternative<sensor::Odometry>(record.payload)) ++report_.odometry;
    if (std::holds_alternative<sensor::LaserScan>(record.payload)) ++report_.scans;
    if (const auto* image = std::get_if<sensor::Image>(&record.payload)) {
      ++report_.images;
      const char* kind = image->encoding == sensor::ImageEncoding::kDepthPng16 ? "depth"
                         : image->camera == sensor::Camera::kRear              ? "rear"
                                                                               : "front";
      entry.content = fs::path("images") / fmt::format("{}_{}.png", image->time, kind);
    }
    if (const auto* cloud = std::get_if<sensor::PointCloud>(&record.payload)) {
      ++report_.clouds;
      entry.content = fs::path("clouds") / fmt::format("{}.xyz32", cloud->time);
    }
    if (!entry.content.empty()) {
      if (!made_[entry.content.parent_path()]) {
        ENFILADE_RETURN_IF_ERROR(MakeFolder(folder_ / entry.content.parent_path()));
        made_[entry.content.parent_path()] = true;
      }
      ENFILADE_RETURN_IF_ERROR(io::WriteFile(folder_ / entry.content, record.content));
    }
    ENFILADE_ASSIGN_OR_RETURN(const std::string line, sources::ToJsonLine(entry));
    log_ << line;
    return absl::OkStatus();
  }
  absl::Status Close() {
    log_.close();
    return log_ ? absl::OkStatus() : CannotWrite(report_.log);
  }

 private:
  fs::path folder_;
  DriveReport& report_;
  std::ofstream log_;
  std::map<fs::path, bool> made_;
};

absl::StatusOr<Campus> ReadBuilding(const std::string& text) {
  ENFILADE_ASSIGN_OR_RETURN(const prior::Building building, prior::ParseBuilding(text));
  return CampusOf(building);
}

absl::StatusOr<std::uint64_t> SeedOfName(const std::string& name, std::string_view kind) {
  std::uint64_t seed = 0;
  const char* end = name.data() + name.size();
  const auto [parsed, error] = std::from_chars(name.data() + kind.size(), end, seed);
  if (error != std::errc() || parsed != end) return InvalidArgument("\"{}\": expected {}SEED", name, kind);
  return seed;
}

}  // namespace

absl::StatusOr<Campus> LoadCampus(const std::string& name) {
  constexpr std::string_view kRandom = "random:";
  constexpr std::string_view kSuites = "suites:";
  constexpr std::string_view kHalls = "halls:";
  if (name.starts_with(kRandom)) {
    ENFILADE_ASSIGN_OR_RETURN(const std::uint64_t seed, SeedOfName(name, kRandom));
    return RandomBuilding(seed);
  }
  if (name.starts_with(kSuites)) {
    ENFILADE_ASSIGN_OR_RETURN(const std::uint64_t seed, SeedOfName(name, kSuites));
    return RandomSuites(seed);
  }
  if (name.starts_with(kHalls)) {
    ENFILADE_ASSIGN_OR_RETURN(const std::uint64_t seed, SeedOfName(name, kHalls));
    return RandomHalls(seed);
  }
  if (!fs::is_regular_file(name)) return ShippedCampus(name);
  ENFILADE_ASSIGN_OR_RETURN(const std::string text, io::ReadFile(name));
  absl::StatusOr<Campus> campus = name.ends_with(kBuildingSuffix) ? ReadBuilding(text) : ParseCampus(text);
  if (!campus.ok()) return WithContext(campus.status(), name);
  return campus;
}

std::string TruthLines(const GroundTruth& truth) {
  std::string lines;
  std::size_t passed = 0;
  const auto passages_until = [&](TimeNs time) {
    for (; passed < truth.passages.size() && truth.passages[passed].time <= time; ++passed) {
      const TruePassage& p = truth.passages[passed];
      lines += nlohmann::json{{"type", "passage"}, {"time_ns", p.time},  {"pose", PoseJson(p.T_campus_robot)},
                              {"level", p.level},  {"door", p.door},     {"from", p.from},
                              {"to", p.to},        {"width_m", p.width}, {"incidence_rad", p.incidence}}
                   .dump() +
               "\n";
    }
  };
  for (const TruePose& pose : truth.poses) {
    passages_until(pose.time);
    lines += nlohmann::json{{"type", "pose"},
                            {"time_ns", pose.time},
                            {"pose", PoseJson(pose.T_campus_robot)},
                            {"level", pose.level},
                            {"area", pose.area}}
                 .dump() +
             "\n";
  }
  passages_until(std::numeric_limits<TimeNs>::max());
  return lines;
}

std::string TruthTrajectory(const GroundTruth& truth) {
  std::string lines;
  for (const TruePose& pose : truth.poses) {
    lines += fmt::format("{}.{:09d} {} {} {}\n", pose.time / kNsPerSecond, pose.time % kNsPerSecond,
                         pose.T_campus_robot.x, pose.T_campus_robot.y, pose.T_campus_robot.yaw);
  }
  return lines;
}

std::string SensorDescription(const SimulationOptions& options) {
  const CameraOptions& camera = options.camera;
  const nlohmann::json document = {
      {"scanner", {{"height_m", options.scanner.height}, {"mount", PoseJson(options.scanner.T_robot_laser)}}},
      {"cloud_scanner",
       {{"height_m", options.cloud.height},
        {"mount", PoseJson(options.cloud.T_robot_scanner)},
        {"rings", options.cloud.rings},
        {"azimuths", options.cloud.azimuths}}},
      {"camera",
       {{"width", camera.width},
        {"height", camera.height},
        {"focal_length_px", camera.focal_length()},
        {"principal_point_px", {camera.width / 2.0, camera.height / 2.0}},
        {"height_m", camera.mount_height},
        {"front_mount", PoseJson(camera.T_robot_camera)},
        {"rear_mount", PoseJson(Pose2{0.0, 0.0, M_PI} * camera.T_robot_camera)},
        {"depth_unit_m", 0.001}}}};
  return document.dump(2) + "\n";
}

absl::StatusOr<DriveReport> WriteDrive(std::shared_ptr<const World> world, const std::string& robot,
                                       const SimulationOptions& options, const fs::path& folder) {
  ENFILADE_ASSIGN_OR_RETURN(RobotSimulation simulation, RobotSimulation::Start(std::move(world), robot, options));
  DriveReport report;
  report.robot = robot;
  DriveWriter writer(folder, report);
  ENFILADE_RETURN_IF_ERROR(writer.Open());
  while (true) {
    ENFILADE_ASSIGN_OR_RETURN(const std::optional<SimulatedRecord> record, simulation.Next());
    if (!record) break;
    ENFILADE_RETURN_IF_ERROR(writer.Add(*record));
  }
  ENFILADE_RETURN_IF_ERROR(writer.Close());
  report.truth = simulation.truth();
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(folder / "truth.jsonl", TruthLines(report.truth)));
  ENFILADE_RETURN_IF_ERROR(io::WriteFile(folder / "truth.txt", TruthTrajectory(report.truth)));
  if (!report.truth.poses.empty()) {
    report.seconds = ToSeconds(report.truth.poses.back().time - report.truth.poses.front().time);
  }
  return report;
}

}  // namespace enfilade::simulator
