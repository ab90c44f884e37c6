// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/log_options.h"
#include "client/cli/output.h"
#include "client/cli/remote.h"
#include "client/sdk/api/localization.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "core/sensor/scan_pairing.h"
#include "enfilade/v1/localization_service.grpc.pb.h"
#include "io/file.h"
#include "proto/convert/geometry.h"

namespace enfilade::cli {
namespace {

struct LocalizeCommandOptions {
  std::string log;
  sources::LogOptions reading;
  std::optional<double> at;  // s
  double drive = 3.0;        // m
  std::string map;
  std::string near;
  double sigma = 1.0;      // m
  double yaw_sigma = 0.3;  // rad
  std::optional<int> level;
  std::string image;
  bool rear = false;
  int results = 5;
};

// Standard input as a file, which readers of logs need: they read it twice.
class CopiedInput {
 public:
  static absl::StatusOr<std::unique_ptr<CopiedInput>> Read() {
    auto copied = std::make_unique<CopiedInput>();
    std::ofstream file(copied->path_, std::ios::binary);
    if (std::cin.peek() != std::char_traits<char>::eof()) file << std::cin.rdbuf();
    file.close();
    if (!file) return ResourceExhausted("{}: cannot be written: is the disk full?", copied->path_.string());
    return copied;
  }
  CopiedInput() : path_(std::filesystem::temp_directory_path() / ("enfilade-" + NewUuid() + ".log")) {}
  ~CopiedInput() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  CopiedInput(const CopiedInput&) = delete;
  CopiedInput& operator=(const CopiedInput&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  const std::filesystem::path path_;
};

// The log's scans with their odometry, up to `until` seconds after its first record.
absl::StatusOr<std::vector<sensor::PairedScan>> ReadScans(sources::LogReader& reader, std::optional<double> until) {
  sensor::ScanPairing pairing{sensor::ScanPairingOptions{}};
  std::vector<sensor::PairedScan> scans;
  std::optional<TimeNs> start;
  for (std::int64_t sequence = 1;; ++sequence) {
    ENFILADE_ASSIGN_OR_RETURN(std::optional<sources::LogEntry> entry, reader.Next());
    if (!entry) break;
    const TimeNs time = sensor::TimeOf(entry->payload);
    if (!start) start = time;
    if (until && ToSeconds(time - *start) > *until) break;
    pairing.Add(sequence, std::move(entry->payload), scans);
  }
  pairing.Flush(scans);
  return scans;
}

// The last scan, and those of the `length` metres that the robot drove before it.
std::vector<sensor::PairedScan> LastOf(std::vector<sensor::PairedScan> scans, double length) {
  if (scans.empty()) return scans;
  std::size_t begin = scans.size() - 1;
  for (double driven = 0.0; begin > 0 && length > 0.0; --begin) {
    const auto& before = scans[begin - 1].T_odom_robot;
    const auto& after = scans[begin].T_odom_robot;
    if (!before || !after) break;
    driven += Between(*before, *after).translation().norm();
    if (driven > length) break;
  }
  scans.erase(scans.begin(), scans.begin() + static_cast<std::ptrdiff_t>(begin));
  return scans;
}

absl::StatusOr<v1::LocalizationPrior> PriorOf(const client::Connection& connection, const Globals& globals,
                                              const LocalizeCommandOptions& options) {
  v1::LocalizationPrior prior;
  if (options.level) prior.set_level(*options.level);
  if (!options.map.empty() && !options.near.empty()) {
    return InvalidArgument("localize: --near names a map already: leave out --map");
  }
  if (!options.map.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const v1::Map map, FindMap(connection, globals, options.map));
    prior.set_map(map.name());
  }
  if (!options.near.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const PoseInMap near, FindPoseInMap(connection, globals, options.near));
    prior.set_map(near.map);
    PoseWithCovariance pose{near.pose, Eigen::Matrix3d::Zero()};
    pose.covariance.diagonal() << options.sigma * options.sigma, options.sigma * options.sigma,
        options.yaw_sigma * options.yaw_sigma;
    *prior.mutable_pose_map_robot() = convert::ToProto(pose);
  }
  return prior;
}

absl::StatusOr<v1::LocalizeRobotRequest> RequestOf(const client::Connection& connection, const Globals& globals,
                                                   const LocalizeCommandOptions& options) {
  std::vector<sensor::PairedScan> scans;
  if (!options.log.empty()) {
    std::unique_ptr<CopiedInput> input;
    if (options.log == "-") {
      ENFILADE_ASSIGN_OR_RETURN(input, CopiedInput::Read());
    }
    ENFILADE_ASSIGN_OR_RETURN(
        sources::LogReader reader,
        sources::LogReader::Open(input ? input->path() : std::filesystem::path(options.log), options.reading));
    ENFILADE_ASSIGN_OR_RETURN(scans, ReadScans(reader, options.at));
    scans = LastOf(std::move(scans), options.drive);
    if (scans.empty()) return InvalidArgument("localize: {} has no scan up to that time", options.log);
  }
  v1::LocalizeRobotRequest request = client::MakeLocalizeRequest(SiteId(globals.site), scans);
  if (!options.image.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(*request.mutable_image()->mutable_content(), io::ReadFile(options.image));
    request.mutable_image()->set_camera(options.rear ? v1::Image::CAMERA_REAR : v1::Image::CAMERA_FRONT);
  }
  ENFILADE_ASSIGN_OR_RETURN(*request.mutable_prior(), PriorOf(connection, globals, options));
  request.set_max_results(options.results);
  return request;
}

nlohmann::json ToJson(const v1::LocatedPose& pose) {
  nlohmann::json document = {{"map", pose.map()},
                             {"pose_map_robot", PoseToJson(pose.pose_map_robot())},
                             {"score", pose.score()},
                             {"log_odds_behind", pose.log_odds_behind()},
                             {"confident", pose.confident()}};
  if (pose.has_pose_world_robot()) document["pose_world_robot"] = PoseToJson(pose.pose_world_robot());
  return document;
}

nlohmann::json ToJson(const v1::LocatedPlace& place) {
  nlohmann::json document = {{"link_point", place.link_point()},
                             {"map", place.map()},
                             {"matches", place.matches()},
                             {"accepted", place.accepted()}};
  if (place.has_pose_map_view()) {
    const v1::Pose2& view = place.pose_map_view();
    document["pose_map_view"] = {{"x", view.x()}, {"y", view.y()}, {"yaw", view.yaw()}};
  }
  return document;
}

template <typename Items>
nlohmann::json ListOf(const Items& items) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& item : items) list.push_back(ToJson(item));
  return list;
}

void PrintPoses(const v1::LocalizeRobotResponse& response) {
  std::vector<std::vector<std::string>> rows;
  for (const v1::LocatedPose& pose : response.poses()) {
    const v1::Pose2& in_map = pose.pose_map_robot().pose();
    const auto& covariance = pose.pose_map_robot().covariance();
    const double sigma = std::sqrt(std::max(covariance.Get(0), covariance.Get(4)));
    const v1::Pose2& in_world = pose.pose_world_robot().pose();
    rows.push_back({std::to_string(rows.size() + 1), IdOf(pose.map()),
                    fmt::format("{:.2f} {:.2f} {:.2f}", in_map.x(), in_map.y(), in_map.yaw()),
                    fmt::format("{:.2f}", sigma), fmt::format("{:.2f}", pose.score()),
                    fmt::format("{:.1f}", pose.log_odds_behind()), pose.confident() ? "certain" : "",
                    pose.has_pose_world_robot()
                        ? fmt::format("{:.2f} {:.2f} {:.2f}", in_world.x(), in_world.y(), in_world.yaw())
                        : "-"});
  }
  if (!rows.empty()) {
    PrintTable(std::cout, {"RANK", "MAP", "X Y YAW", "SIGMA M", "SCORE", "BEHIND", "", "IN THE WORLD"}, rows);
  }
}

void PrintPlaces(const v1::LocalizeRobotResponse& response) {
  std::vector<std::vector<std::string>> rows;
  for (const v1::LocatedPlace& place : response.places()) {
    const v1::Pose2& view = place.pose_map_view();
    rows.push_back(
        {IdOf(place.link_point()), IdOf(place.map()), std::to_string(place.matches()), place.accepted() ? "yes" : "no",
         place.has_pose_map_view() ? fmt::format("{:.2f} {:.2f} {:.2f}", view.x(), view.y(), view.yaw()) : "-"});
  }
  if (!rows.empty()) PrintTable(std::cout, {"LINK POINT", "MAP", "MATCHES", "SAME PLACE", "SEEN FROM"}, rows);
}

absl::Status RunLocalize(const Globals& globals, const LocalizeCommandOptions& options) {
  if (options.log.empty() && options.image.empty()) {
    return InvalidArgument("localize: give a LOG (- for standard input), --image or both");
  }
  const client::Connection connection = ConnectionOf(globals);
  ENFILADE_ASSIGN_OR_RETURN(const v1::LocalizeRobotRequest request, RequestOf(connection, globals, options));
  ENFILADE_ASSIGN_OR_RETURN(const v1::LocalizeRobotResponse response,
                            connection.Call(&v1::LocalizationService::Stub::LocalizeRobot, request));
  if (globals.json) {
    PrintJson(std::cout, {{"scans", request.scans_size()},
                          {"poses", ListOf(response.poses())},
                          {"places", ListOf(response.places())},
                          {"reason", response.reason()},
                          {"maps_searched", response.maps_searched()},
                          {"graph_version", response.graph_version()}});
    return absl::OkStatus();
  }
  PrintPoses(response);
  PrintPlaces(response);
  std::cout << fmt::format("{} ({} scans, {} maps searched)\n", response.reason(), request.scans_size(),
                           response.maps_searched());
  return absl::OkStatus();
}

}  // namespace

void AddLocalize(CLI::App& app, const Globals& globals) {
  auto options = std::make_shared<LocalizeCommandOptions>();
  CLI::App* localize = AddCommand(app, "localize", "Where a robot is in the site's maps, by its last scans or an image",
                                  [&globals, options] { return RunLocalize(globals, *options); });
  localize->add_option("LOG", options->log, "A recorded log (docs/logs.md); - for standard input");
  AddLogOptions(*localize, options->reading);
  AddNoOdometry(*localize, options->reading);
  localize->add_option("--at", options->at, "The moment, s after the log's first record (default: its end)");
  localize
      ->add_option("--drive", options->drive,
                   "Also the scans of so many metres before, if there is odometry; 0: one scan")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  localize->add_option("--map", options->map, "Search only this map");
  localize->add_option("--near", options->near, "Search only near this pose: MAP,X,Y,YAW in metres and radians");
  localize->add_option("--sigma", options->sigma, "Standard deviation of --near's position, m")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  localize->add_option("--yaw-sigma", options->yaw_sigma, "Standard deviation of --near's heading, rad")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  localize->add_option("--level", options->level, "Search only this level");
  localize->add_option("--image", options->image, "A camera image (PNG, JPEG): ranks the places with kept images");
  localize->add_flag("--rear", options->rear, "The image is the rear camera's");
  localize->add_option("--results", options->results, "Poses and places at most")->capture_default_str();
}

}  // namespace enfilade::cli
