// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/log_run.h"

#include <chrono>
#include <cmath>
#include <deque>
#include <fstream>
#include <functional>
#include <memory>
#include <stdexcept>

#include "client/sources/formats/json_lines_writer.h"
#include "client/sources/log_reader.h"
#include "core/base/noise.h"
#include "core/sensor/record.h"
#include "fmt/format.h"
#include "tests/e2e/campus/campus_run.h"
#include "tests/e2e/campus/json_lines.h"
#include "tests/e2e/campus/kept_files.h"
#include "tests/e2e/campus/mapped_state.h"
#include "tests/support/slowdown.h"

namespace enfilade::testing {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRobot = "recorded";

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void WritePose(std::ostream& out, TimeNs time, const Pose2& pose) {
  out << fmt::format("{}.{:09d} {} {} {}\n", time / kNsPerSecond, time % kNsPerSecond, pose.x, pose.y, pose.yaw);
}

// Copies the log as JSON lines, with its odometry changed.
void CopyLog(const fs::path& log, const fs::path& copy, const std::function<void(sensor::Odometry&)>& change) {
  auto reader = sources::LogReader::Open(log);
  if (!reader.ok()) throw std::runtime_error(std::string(reader.status().message()));
  std::ofstream out(copy);
  out << sources::JsonLinesHeader();
  bool has_odometry = false;
  while (true) {
    auto entry = reader->Next();
    if (!entry.ok()) throw std::runtime_error(std::string(entry.status().message()));
    if (!*entry) break;
    if (auto* odometry = std::get_if<sensor::Odometry>(&(*entry)->payload)) {
      change(*odometry);
      has_odometry = true;
    }
    const auto line = sources::ToJsonLine(**entry);
    if (!line.ok()) throw std::runtime_error(std::string(line.status().message()));
    out << *line;
  }
  if (!has_odometry) throw std::runtime_error(log.string() + ": has no odometry");
}

class LogExpedition {
 public:
  LogExpedition(WholeSystem& system, const LogRun& run) : system_(system), run_(run), log_(run.log) {
    result_.site = SiteIdOf(run.log.filename().string() + "-" + std::to_string(run.seed));
  }

  LogResult Run() {
    system_.CreateSite(result_.site);
    fs::path reference = run_.reference;
    if (run_.simulate_odometry) {
      log_ = File(".log.jsonl");
      reference = File(".reference.txt");
      SimulateOdometry(run_, log_, reference);
    } else if (run_.odometry_ahead > 0) {
      log_ = File(".log.jsonl");
      DelayOdometry(run_.log, run_.odometry_ahead, log_);
    }
    Drive();
    ReadState();
    MapAsOne();
    if (!run_.keep.empty()) Keep();
    if (result_.poses == 0) return result_;
    const std::vector<TimedPose> world = ReadTrajectory(File(".world.txt"));
    const std::vector<TimedPose> one_map = ReadTrajectory(File(".slam") / "trajectory.txt");
    result_.difference = ErrorByReference(world, one_map);
    if (run_.rooms) {
      result_.rooms = Compare({RoomsEntered(kRobot, one_map, *run_.rooms)}, {}, state_, {.doors = false});
    }
    if (!run_.relations.empty()) {
      const std::vector<Relation> relations = ReadRelations(run_.relations);
      result_.error = ErrorByRelations(world, relations);
      result_.slam_error = ErrorByRelations(one_map, relations);
    } else if (!reference.empty()) {
      const std::vector<TimedPose> right = ReadTrajectory(reference);
      result_.error = ErrorByReference(world, right);
      result_.slam_error = ErrorByReference(one_map, right);
    }
    return result_;
  }

 private:
  fs::path File(const std::string& suffix) const { return system_.directory() / (result_.site + suffix); }

  void RunTool(std::vector<std::string> arguments, const fs::path& output) const {
    arguments.insert(arguments.end(), run_.reading.begin(), run_.reading.end());
    Process process(arguments, output);
    if (process.Wait(std::chrono::minutes(60 * kSlowdown)) != 0) {
      throw std::runtime_error(arguments[0] + " failed: " + TailOf(output));
    }
  }

  void Drive() {
    const auto start = std::chrono::steady_clock::now();
    RunTool({Program("enfilade"), "--json", "--server", system_.server().address(), "--site", result_.site, "robot",
             log_.string(), "--robot", kRobot, "--map", "M0", "--spool", File(".spool").string(), "--wait"},
            File(".jsonl"));
    result_.seconds = SecondsSince(start);
    for (const nlohmann::json& line : ReadJsonLines(File(".jsonl"))) {
      const std::string event = line.value("event", "");
      if (event == "end") result_.passages = line.value("passages", 0);
      if (event != "verdict") continue;
      result_.verdicts.push_back(fmt::format("{}: {} {}", line.at("session").get<std::string>(),
                                             line.at("decision").get<std::string>(),
                                             line.at("reason").get<std::string>()));
    }
  }

  void ReadState() {
    state_ = ReadWhenQuiet(system_.server().Connect(), result_.site, {kRobot});
    const MappedState& state = state_;
    result_.maps = static_cast<int>(state.maps.size());
    for (const MappedLinkPoint& point : state.link_points) result_.joins += point.joins ? 1 : 0;
    result_.candidates = state.candidates();
    result_.components = state.components();
    const std::vector<client::MappedStretch>& stretches = state.stretches.at(kRobot);
    result_.sessions = static_cast<int>(stretches.size());
    const client::WorldTrajectory way = client::JoinStretches(stretches);
    std::ofstream out(File(".world.txt"));
    for (const client::WorldPose& pose : way.poses) WritePose(out, pose.time, pose.T_world_robot);
    result_.poses = static_cast<int>(way.poses.size());
    for (const client::MappedStretch& stretch : way.left_out) {
      result_.left_out += static_cast<int>(stretch.poses.size());
    }
  }

  void MapAsOne() {
    const auto start = std::chrono::steady_clock::now();
    RunTool({Program("enfilade"), "--quiet", "slam", log_.string(), "-o", File(".slam").string(), "--plot"},
            File(".slam.txt"));
    result_.slam_seconds = SecondsSince(start);
  }

  void Keep() const {
    const fs::path folder = run_.keep / result_.site;
    KeepSite(system_, result_.site, {kRobot}, folder);
    KeepFile(File(".jsonl"), folder / "robot.jsonl");
    KeepFile(File(".slam") / "plot.png", folder / "slam.png");
    KeepFile(File(".slam") / "trajectory.txt", folder / "slam.txt");
  }

  WholeSystem& system_;
  const LogRun& run_;
  fs::path log_;
  MappedState state_;
  LogResult result_;
};

}  // namespace

std::optional<double> LogResult::ratio() const {
  if (!error || !slam_error || error->used == 0 || !(slam_error->metres > 0.0)) return std::nullopt;
  return error->metres / slam_error->metres;
}

LogResult RunLog(WholeSystem& system, const LogRun& run) { return LogExpedition(system, run).Run(); }

void SimulateOdometry(const LogRun& run, const fs::path& log, const fs::path& reference) {
  std::ofstream right(reference);
  Noise noise(run.seed);
  std::optional<Pose2> last;
  Pose2 drifted;
  CopyLog(run.log, log, [&](sensor::Odometry& odometry) {
    const Pose2 pose = odometry.T_odom_robot;
    const Pose2 step = last ? Between(*last, pose) : Pose2{};
    const double d = step.translation().norm();
    const double turn = 3.0 * kDegree * std::sqrt(d) + 0.02 * std::abs(step.yaw);
    const double longer = 1.0 + 0.05 * noise.Normal();
    drifted = drifted * Pose2{step.x * longer, step.y * longer, step.yaw + turn * noise.Normal()};
    WritePose(right, odometry.time, pose);
    last = pose;
    odometry.T_odom_robot = drifted;
  });
}

void DelayOdometry(const fs::path& log, int samples, const fs::path& copy) {
  std::deque<Pose2> poses;
  CopyLog(log, copy, [&](sensor::Odometry& odometry) {
    poses.push_back(odometry.T_odom_robot);
    if (std::ssize(poses) > samples + 1) poses.pop_front();
    odometry.T_odom_robot = poses.front();
  });
}

}  // namespace enfilade::testing
