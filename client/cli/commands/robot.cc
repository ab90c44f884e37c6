// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "client/cli/commands/commands.h"
#include "client/cli/interrupt.h"
#include "client/cli/log_options.h"
#include "client/cli/numbers.h"
#include "client/cli/pose_in_map.h"
#include "client/cli/remote.h"
#include "client/cli/replay/replay_session.h"
#include "client/robot/input/commands.h"
#include "client/robot/run.h"
#include "core/base/error.h"
#include "core/base/mutex.h"
#include "core/base/status_macros.h"
#include "fmt/chrono.h"
#include "io/file.h"

namespace enfilade::cli {
namespace {

struct RobotCommandOptions {
  std::string source;
  std::string campus;
  std::string robot = "robot";
  std::string map;
  std::string on_existing_map;
  bool hand = false;
  std::string preset = "default";
  std::string options_file;
  bool print_options = false;
  std::string spool;
  std::string rate = "max";
  std::string commands;
  bool wait = false;
  sources::LogOptions reading;  // of a log
  std::string truth;
  int laps = 0;
  simulator::SimulationOptions simulation;
};

absl::StatusOr<robot::RobotOptions> LoadAgentOptions(const RobotCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(robot::RobotOptions loaded, robot::RobotPreset(options.preset));
  if (!options.options_file.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string text, io::ReadFile(options.options_file));
    absl::StatusOr<robot::RobotOptions> parsed = robot::ParseRobotOptions(text, loaded);
    if (!parsed.ok()) return WithContext(parsed.status(), options.options_file);
    loaded = *std::move(parsed);
  }
  if (options.hand) loaded.automatic = false;
  return loaded;
}

absl::Status CheckRobot(const RobotCommandOptions& options) {
  if (options.source.empty() == options.campus.empty()) {
    return InvalidArgument("give one source of sensor data: a log, - for JSON lines on standard input, or --campus");
  }
  if (!IsValidResourceId(options.robot)) {
    return InvalidArgument("--robot is \"{}\": expected 1 to 63 of a-z, 0-9 and \"-\"", options.robot);
  }
  if (!options.map.empty() && !options.on_existing_map.empty()) {
    return InvalidArgument("--map starts a new map and --on-existing-map continues one: give only one of them");
  }
  return absl::OkStatus();
}

using Start = std::variant<robot::RecordNewMap, robot::MapOnExistingMap, robot::LocateRobot>;

// A new map, the pose of --on-old-map: MAP,X,Y,YAW, or unknown.
absl::StatusOr<Start> StartOf(const RobotCommandOptions& options, const Eigen::Matrix3d& covariance) {
  if (!options.map.empty()) return robot::RecordNewMap{options.map};
  if (options.on_existing_map.empty()) return robot::LocateRobot{};
  ENFILADE_ASSIGN_OR_RETURN(const PoseInMap start, ParsePoseInMap(options.on_existing_map));
  return robot::MapOnExistingMap{start.map, {start.pose, covariance}};
}

absl::StatusOr<std::unique_ptr<robot::Source>> OpenSource(const RobotCommandOptions& options,
                                                          const robot::RobotOptions& robot_options,
                                                          const Eigen::Matrix3d& covariance) {
  if (options.source == "-") return robot::OpenLines(STDIN_FILENO, std::filesystem::current_path(), covariance);
  if (!options.source.empty()) return robot::OpenLog(options.source, options.reading);
  simulator::SimulationOptions simulation = options.simulation;
  if (options.laps > 0) simulation.laps = options.laps;
  if (options.reading.field_of_view) simulation.scanner.field_of_view = *options.reading.field_of_view;
  if (options.reading.range_max) simulation.scanner.range_max = *options.reading.range_max;
  const bool by_depth = robot_options.environment.criterion == 1 || robot_options.environment.criterion == 2;
  if (by_depth && simulation.depth_hz == 0.0) simulation.depth_hz = 2.0;
  return robot::OpenSimulation(options.campus, options.robot, simulation, options.truth);
}

absl::StatusOr<std::string> SpoolPathOf(const RobotCommandOptions& options) {
  if (!options.spool.empty()) return options.spool;
  return DefaultSpoolPath("robot-" + options.robot);
}

absl::StatusOr<std::unique_ptr<client::Spool>> OpenSpool(const std::string& path, const robot::RobotOptions& options) {
  client::SpoolOptions spool_options;
  spool_options.max_bytes = std::llround(options.spool.max_mib * 1024.0 * 1024.0);
  return client::Spool::Open(path, spool_options);
}

// Prints events on standard output: lines for people, or one JSON object a line.
class Console {
 public:
  explicit Console(const Globals& globals) : json_(globals.json), quiet_(globals.quiet) {}

  void Show(const robot::Notification& notification) {
    MutexLock lock(mutex_);
    if (json_) {
      nlohmann::json line = notification.fields.is_object() ? notification.fields : nlohmann::json::object();
      line["event"] = notification.event;
      std::cout << line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << std::endl;
    } else if (!quiet_ && !notification.text.empty()) {
      const std::time_t now = std::time(nullptr);
      std::tm local{};
      localtime_r(&now, &local);
      std::cout << fmt::format("{:%H:%M:%S} {}", local, notification.text) << std::endl;
    }
  }

 private:
  const bool json_;
  const bool quiet_;
  Mutex mutex_;
};

robot::Notification Summary(const robot::Agent& agent, const absl::Status& status) {
  const robot::AgentCounts& counts = agent.counts();
  return {
      "end",
      fmt::format("{} sessions, {} candidates, {} passages; {} records, {} of them images and clouds; {} refused, {} "
                  "invalid",
                  counts.sessions, counts.candidates, counts.passages, counts.records, counts.evidence, counts.refused,
                  counts.invalid),
      {{"sessions", counts.sessions},
       {"candidates", counts.candidates},
       {"passages", counts.passages},
       {"records", counts.records},
       {"evidence", counts.evidence},
       {"refused", counts.refused},
       {"invalid", counts.invalid},
       {"ok", status.ok()}}};
}

absl::Status RunRobot(const Globals& globals, const RobotCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(robot::RobotOptions robot_options, LoadAgentOptions(options));
  if (options.print_options) {
    std::cout << robot::FormatRobotOptions(robot_options);
    return absl::OkStatus();
  }
  ENFILADE_RETURN_IF_ERROR(CheckRobot(options));
  robot::RunOptions run;
  ENFILADE_ASSIGN_OR_RETURN(run.rate, ParseRate(options.rate));
  run.live = options.source == "-";
  run.wait = options.wait;
  run.pose_covariance = Eigen::Vector3d(robot_options.initial_variance_x, robot_options.initial_variance_y,
                                        robot_options.initial_variance_theta)
                            .asDiagonal();
  if (run.live || run.rate) robot_options.spool.wait_when_full = false;

  robot::AgentSetup setup;
  const SiteId site(globals.site);
  setup.site = site;
  setup.robot = RobotId(options.robot);
  setup.source = options.campus.empty() ? options.source : "simulator " + options.campus;
  setup.options = robot_options;
  ENFILADE_ASSIGN_OR_RETURN(setup.start, StartOf(options, run.pose_covariance));
  ENFILADE_ASSIGN_OR_RETURN(const std::unique_ptr<robot::Source> source,
                            OpenSource(options, robot_options, run.pose_covariance));
  std::optional<robot::LineReader> commands;
  if (!run.live && (isatty(STDIN_FILENO) || options.commands == "-")) commands.emplace(STDIN_FILENO);

  ENFILADE_ASSIGN_OR_RETURN(const std::string spool_path, SpoolPathOf(options));
  ENFILADE_ASSIGN_OR_RETURN(const std::unique_ptr<client::Spool> spool, OpenSpool(spool_path, robot_options));
  Console console(globals);
  const robot::NotificationListener listener = [&console](const robot::Notification& notification) {
    console.Show(notification);
  };
  const client::Connection connection = ConnectionOf(globals);
  const InterruptGuard interrupt;
  const std::function<bool()> interrupted = [&interrupt] { return interrupt.interrupted(); };
  robot::UploaderOptions uploader_options;
  uploader_options.global_pose = robot_options.use_global_tracker;
  robot::Uploader uploader(connection, *spool, {setup.site, setup.robot}, listener, uploader_options);
  ENFILADE_ASSIGN_OR_RETURN(const std::unique_ptr<robot::Agent> agent,
                            robot::Agent::Make(std::move(setup), {connection, *spool, uploader, listener, interrupted,
                                                                  robot::LocateOnServer(connection, site)}));
  uploader.Start();
  absl::Status status =
      robot::Run({*agent, uploader, *source, commands ? &*commands : nullptr, interrupted, listener}, run);
  uploader.Stop();
  console.Show(Summary(*agent, status));
  if (status.ok() || spool->usage().records == 0) return status;
  return absl::Status(status.code(),
                      std::string(status.message()) +
                          fmt::format("; {} records wait in {} for the next run", spool->usage().records, spool_path));
}

void AddSimulation(CLI::App* command, const std::shared_ptr<RobotCommandOptions>& options) {
  simulator::SimulationOptions& simulation = options->simulation;
  simulation.image_hz = 2.0;
  simulation.cloud_hz = 1.0;
  simulation.near_doors = 4.5;
  command->add_option("--campus", options->campus, "Drive through a simulated campus (see `enfilade simulate --help`)");
  command->add_option("--seed", simulation.seed, "Campus: the seed of all noise")->capture_default_str();
  command->add_option("--laps", options->laps, "Campus: rounds of the route (default: the campus's)");
  command->add_option("--start-after", simulation.start_after,
                      "Campus: the robot is switched on at this time of its route, s: it starts elsewhere");
  command->add_option("--image-hz", simulation.image_hz, "Campus: rate of images, Hz")->capture_default_str();
  command->add_option("--cloud-hz", simulation.cloud_hz, "Campus: rate of point clouds, Hz")->capture_default_str();
  command->add_option("--depth-hz", simulation.depth_hz,
                      "Campus: rate of depth images, Hz (default: 2 if config_criterion needs them)");
  command
      ->add_option("--near-doors", simulation.near_doors,
                   "Campus: images and clouds only within this distance of a door, m")
      ->capture_default_str();
  command->add_option("--truth", options->truth, "Campus: write the ground truth into this file");
}

}  // namespace

void AddRobot(CLI::App& app, const Globals& globals) {
  auto options = std::make_shared<RobotCommandOptions>();
  CLI::App* command =
      AddCommand(app, "robot", "Map a campus as a robot does: find doors, one map per room (docs/robot.md)",
                 [&globals, options] { return RunRobot(globals, *options); });
  command->add_option("SOURCE", options->source, "A recorded log, or - for JSON lines on standard input");
  AddSimulation(command, options);
  command->add_option("--robot", options->robot, "Its id; created if missing. Campus: the robot that drives")
      ->capture_default_str();
  command->add_option("--map", options->map,
                      "The name of the first map, which begins here (default: where the robot is located by its scans, "
                      "or a new map)");
  command->add_option("--on-existing-map,--on-old-map", options->on_existing_map,
                      "Start in an existing map: MAP,X,Y,YAW (m, rad)");
  command->add_flag("--hand", options->hand, "No detectors: commands name the doors, starting with the main menu");
  command->add_option("--preset", options->preset, "default, original-yaml or original-code")->capture_default_str();
  command->add_option("--options", options->options_file, "A YAML file with options that override the preset");
  command->add_flag("--print-options", options->print_options, "Print all options as YAML and exit");
  command->add_option("--spool", options->spool, "The file that keeps records until the server acknowledges them");
  command->add_option("--rate", options->rate, "max, real (as recorded) or a factor such as 2.5")
      ->capture_default_str();
  command
      ->add_option("--commands", options->commands, "-: read commands from standard input even if it is not a terminal")
      ->check(CLI::IsMember({"-"}));
  command->add_flag("--wait", options->wait,
                    "At the end, wait until the server has mapped everything and judged all doors");
  AddLogOptions(*command, options->reading);
  command->get_option("--fov")->description(
      "Field of view of scans that do not state theirs, degrees. Campus: of the scanner");
  command->get_option("--range-max")
      ->description("Ranges of this or more mean \"no return\", m. Campus: the scanner's range");
  command->footer("Commands, on the terminal:\n" + robot::CommandHelp() +
                  "Examples:\n"
                  "  enfilade robot --campus figure1 --robot r1 --map Hall --wait\n"
                  "  enfilade robot drive.jsonl --robot r7 --rate real --hand\n"
                  "  my-driver | enfilade --json robot - --robot r7 --options robot.yaml");
}

}  // namespace enfilade::cli
