// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus/campus_run.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <thread>

#include "client/simulator/simulation.h"
#include "client/simulator/simulation_files.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "fmt/format.h"
#include "tests/e2e/campus/json_lines.h"
#include "tests/e2e/campus/kept_files.h"
#include "tests/support/slowdown.h"

namespace enfilade::testing {
namespace {

using nlohmann::json;

constexpr const char* kFirstMap = "M0";

std::shared_ptr<const simulator::World> LoadWorld(const std::string& name) {
  auto campus = simulator::LoadCampus(name);
  if (!campus.ok()) throw std::runtime_error(std::string(campus.status().message()));
  return std::make_shared<const simulator::World>(*std::move(campus));
}

Pose2 StartOf(const std::shared_ptr<const simulator::World>& world, const std::string& robot) {
  auto simulation = simulator::RobotSimulation::Start(world, robot, {});
  if (!simulation.ok()) throw std::runtime_error(std::string(simulation.status().message()));
  while (simulation->truth().poses.empty()) {
    if (const auto record = simulation->Next(); !record.ok() || !*record) {
      throw std::runtime_error(robot + " does not drive");
    }
  }
  return simulation->truth().poses.front().T_campus_robot;
}

class Expedition {
 public:
  Expedition(WholeSystem& system, const CampusRun& run)
      : system_(system), run_(run), world_(LoadWorld(run.campus)), connection_(system.server().Connect()) {
    result_.robots = run.robots;
    if (result_.robots.empty()) {
      if (world_->campus().robots.empty()) throw std::runtime_error(run.campus + " has no robots");
      result_.robots.push_back(world_->campus().robots.front().id);
    }
    result_.site = SiteIdOf(fmt::format("{}-{}", CampusNameOf(run.campus), run.seed));
  }

  CampusResult Run() {
    const auto start = std::chrono::steady_clock::now();
    system_.CreateSite(result_.site);
    for (const std::string& robot : result_.robots) Begin(robot);
    for (Running& one : running_) Await(one);
    const MappedState state = ReadWhenQuiet(connection_, result_.site, result_.robots);
    std::vector<DriveTruth> truths;
    for (const Running& one : running_) truths.push_back(ReadTruth(one.robot, one.truth));
    result_.comparison = Compare(truths, DoorsOf(world_->campus()), state);
    result_.graph = MeasureConsistency(truths, state);
    for (std::size_t i = 0; i < truths.size(); ++i) {
      ReadOutput(truths[i], running_[i].output);
      MeasureLastPose(truths[i]);
    }
    result_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!run_.keep.empty()) Keep(truths);
    return result_;
  }

 private:
  struct Running {
    std::string robot;
    std::filesystem::path truth;
    std::filesystem::path output;
    std::unique_ptr<Process> process;
    bool done = false;
  };

  void Begin(const std::string& robot) {
    if (running_.size() == 1) AwaitFirstMap();
    if (!running_.empty() && run_.start == Start::kAfterwards) Await(running_.back());
    if (!running_.empty() && run_.start == Start::kDelayed) {
      std::this_thread::sleep_for(std::chrono::duration<double>(run_.delay_s));
    }
    const auto file = [&](const char* suffix) { return system_.directory() / (result_.site + "-" + robot + suffix); };
    Running one{robot, file(".truth.jsonl"), file(".jsonl"), nullptr, false};
    one.process = std::make_unique<Process>(CommandOf(one, file(".spool")), one.output);
    running_.push_back(std::move(one));
  }

  std::vector<std::string> CommandOf(const Running& one, const std::filesystem::path& spool) {
    std::vector<std::string> command = {Program("enfilade"),
                                        "--json",
                                        "--server",
                                        system_.server().address(),
                                        "--site",
                                        result_.site,
                                        "robot",
                                        "--campus",
                                        run_.campus,
                                        "--robot",
                                        one.robot,
                                        "--seed",
                                        std::to_string(run_.seed),
                                        "--spool",
                                        spool.string(),
                                        "--truth",
                                        one.truth.string(),
                                        "--wait"};
    const auto add = [&command](const char* option, const auto& value) {
      command.insert(command.end(), {option, fmt::format("{}", value)});
    };
    if (run_.laps > 0) add("--laps", run_.laps);
    if (run_.image_hz) add("--image-hz", *run_.image_hz);
    if (run_.cloud_hz) add("--cloud-hz", *run_.cloud_hz);
    if (run_.field_of_view_deg) add("--fov", *run_.field_of_view_deg);
    if (running_.empty()) {
      add("--map", kFirstMap);
    } else if (!run_.unknown_starts) {
      add("--on-existing-map", StartInMap(one.robot));
    }
    return command;
  }

  // MAP,X,Y,YAW: a robot's start in the map in which the first robot began, wherever that is by now.
  std::string StartInMap(const std::string& robot) const {
    const std::string& first = result_.robots[0];
    Pose2 start = Between(StartOf(world_, first), StartOf(world_, robot));
    std::string map = kFirstMap;
    const auto stretches = client::ReadStretches(connection_, "sites/" + result_.site + "/robots/" + first);
    if (stretches.ok() && !stretches->empty() && !stretches->front().poses.empty()) {
      start = stretches->front().poses.front().T_map_robot * start;
      map = stretches->front().map.substr(stretches->front().map.rfind('/') + 1);
    }
    return fmt::format("{},{},{},{}", map, start.x, start.y, start.yaw);
  }

  void Await(Running& one) {
    if (one.done) return;
    const auto exit_code = one.process->Wait(std::chrono::minutes(30 * kSlowdown));
    if (exit_code != 0) throw std::runtime_error(one.robot + " failed: " + TailOf(one.output));
    one.done = true;
  }

  // The others begin in the first robot's first map.
  void AwaitFirstMap() const {
    const bool exists = Eventually([&] {
      v1::GetGraphRequest request;
      request.set_site("sites/" + result_.site);
      const auto graph = connection_.Call(&v1::GraphService::Stub::GetGraph, request);
      return graph.ok() && graph->graph().maps_size() > 0;
    });
    if (!exists) throw std::runtime_error("the first robot's map does not exist");
  }

  void ReadOutput(const DriveTruth& truth, const std::filesystem::path& output) {
    for (const json& line : ReadJsonLines(output)) {
      const std::string event = line.value("event", "");
      if (event == "global_pose" && result_.graph.T_campus_world) {
        MeasurePose(truth, *result_.graph.T_campus_world, line);
      }
      if (event != "verdict") continue;
      const std::string entered = line.at("entered_map");
      result_.verdicts.push_back(fmt::format(
          "{} {}: {} {} {}", truth.robot, line.at("session").get<std::string>(), line.at("decision").get<std::string>(),
          entered.substr(entered.rfind('/') + 1), line.at("reason").get<std::string>()));
    }
  }

  void MeasurePose(const DriveTruth& truth, const Pose2& T_campus_world, const json& line) {
    const std::vector<double> values = line.at("covariance");
    if (values.size() != 9) return;
    const Pose2 estimate = T_campus_world * PoseOf(line.at("pose_world_robot"));
    const Pose2 right = TruthAt(truth, line.at("time_ns"));
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() = Eigen::Rotation2D<double>(T_campus_world.yaw).toRotationMatrix();
    const Eigen::Matrix3d covariance = Eigen::Map<const Eigen::Matrix3d>(values.data());  // symmetric
    result_.poses.Add({estimate.x - right.x, estimate.y - right.y, WrapAngle(estimate.yaw - right.yaw)},
                      turn * covariance * turn.transpose());
  }

  void MeasureLastPose(const DriveTruth& truth) {
    v1::GetGlobalPoseRequest request;
    request.set_robot("sites/" + result_.site + "/robots/" + truth.robot);
    const auto response = connection_.Call(&v1::GraphService::Stub::GetGlobalPose, request);
    if (!response.ok() || !response->global_pose().has_pose_world_robot()) {
      result_.comparison.wrong.push_back(truth.robot + " has no pose in the world");
      result_.comparison.exact = false;
      result_.has_last_poses = false;
      return;
    }
    const v1::GlobalPose& pose = response->global_pose();
    const v1::Pose2& world = pose.pose_world_robot().pose();
    const Pose2 estimate = result_.comparison.T_campus_world * Pose2{world.x(), world.y(), world.yaw()};
    const Pose2 right = TruthAt(truth, pose.report_time().seconds() * kNsPerSecond + pose.report_time().nanos());
    result_.final_error = std::max(result_.final_error, (estimate.translation() - right.translation()).norm());
    result_.final_yaw_error = std::max(result_.final_yaw_error, std::abs(WrapAngle(estimate.yaw - right.yaw)));
  }

  void Keep(const std::vector<DriveTruth>& truths) const {
    const std::filesystem::path folder = run_.keep / result_.site;
    KeepSite(system_, result_.site, result_.robots, folder);
    KeepPlans(*world_, truths, folder);
    for (const Running& one : running_) {
      KeepFile(one.truth, folder / (one.robot + ".truth.jsonl"));
      KeepFile(one.output, folder / (one.robot + ".jsonl"));
    }
  }

  WholeSystem& system_;
  const CampusRun& run_;
  const std::shared_ptr<const simulator::World> world_;
  const client::Connection connection_;
  std::vector<Running> running_;
  CampusResult result_;
};

}  // namespace

CampusResult RunCampus(WholeSystem& system, const CampusRun& run) { return Expedition(system, run).Run(); }

std::string CampusNameOf(const std::string& campus) {
  const std::filesystem::path path(campus);
  if (!path.has_extension()) return campus;
  const std::string name = path.stem().string();
  return name.substr(0, name.rfind(".building"));
}

std::string SiteIdOf(const std::string& text) {
  std::string id;
  for (const char c : text) {
    const bool fits = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    const char small = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : '-');
    const char next = fits ? c : small;
    if (next != '-' || (!id.empty() && id.back() != '-')) id += next;
  }
  if (id.size() > 63) id.erase(0, id.size() - 63);
  while (!id.empty() && id.front() == '-') id.erase(0, 1);
  while (!id.empty() && id.back() == '-') id.pop_back();
  return id;
}

}  // namespace enfilade::testing
