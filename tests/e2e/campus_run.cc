// SPDX-License-Identifier: Apache-2.0
#include "tests/e2e/campus_run.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>

#include "client/simulator/campus/shipped_campuses.h"
#include "client/simulator/simulation.h"
#include "core/geometry/pose2.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "fmt/format.h"
#include "fmt/ranges.h"
#include "nlohmann/json.hpp"
#include "tests/support/slowdown.h"

namespace enfilade::testing {
namespace {

using nlohmann::json;

constexpr double kChiSquared95 = 5.991;  // 2 degrees of freedom

Pose2 PoseOf(const json& pose) { return {pose.at("x_m"), pose.at("y_m"), pose.at("yaw_rad")}; }

std::vector<json> LinesOf(const std::filesystem::path& file) {
  std::vector<json> lines;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const json object = json::parse(line, nullptr, false);
    if (object.is_object()) lines.push_back(object);
  }
  return lines;
}

// One robot's drive: the truth, and what the server reported.
struct Drive {
  std::string robot;
  std::map<std::int64_t, Pose2> poses;  // by time
  std::string first_area;
  std::vector<json> passages;  // of the truth
  std::vector<json> verdicts;  // on passages
  std::vector<json> global_poses;
};

Drive ReadDrive(const std::string& robot, const std::filesystem::path& truth, const std::filesystem::path& output) {
  Drive drive;
  drive.robot = robot;
  for (const json& line : LinesOf(truth)) {
    if (line.at("type") == "passage") drive.passages.push_back(line);
    if (line.at("type") != "pose") continue;
    if (drive.poses.empty()) drive.first_area = line.at("area");
    drive.poses[line.at("time_ns")] = PoseOf(line.at("pose"));
  }
  for (const json& line : LinesOf(output)) {
    const std::string event = line.value("event", "");
    if (event == "verdict" && !line.at("entered_map").get<std::string>().empty()) drive.verdicts.push_back(line);
    if (event == "global_pose") drive.global_poses.push_back(line);
  }
  return drive;
}

Pose2 TruthAt(const Drive& drive, std::int64_t time) {
  auto after = drive.poses.lower_bound(time);
  if (after == drive.poses.begin()) return after->second;
  if (after == drive.poses.end()) return drive.poses.rbegin()->second;
  const auto before = std::prev(after);
  const double t = static_cast<double>(time - before->first) / static_cast<double>(after->first - before->first);
  return Interpolate(before->second, after->second, t);
}

// Which of the server's names stand for which true names.
class Names {
 public:
  // The server called `true_name` `name`. False if `name` already stands for another.
  bool Note(const std::string& true_name, const std::string& name) {
    const auto known = true_names_.emplace(name, true_name).first;
    if (known->second == true_name) names_[true_name].insert(name);
    return known->second == true_name;
  }
  // Adds those with several names.
  void AddDuplicates(const char* what, std::vector<std::string>& wrong) const {
    for (const auto& [true_name, names] : names_) {
      if (names.size() > 1) wrong.push_back(fmt::format("{} {} exists {} times", what, true_name, names.size()));
    }
  }
  std::size_t size() const { return names_.size(); }

 private:
  std::map<std::string, std::string> true_names_;
  std::map<std::string, std::set<std::string>> names_;
};

class Judgement {
 public:
  Judgement(const client::Connection& connection, const std::string& site) : connection_(connection) {
    v1::GetGraphRequest request;
    request.set_site("sites/" + site);
    const auto response = connection_.Call(&v1::GraphService::Stub::GetGraph, request);
    if (!response.ok()) throw std::runtime_error("GetGraph: " + response.status().ToString());
    graph_ = response->graph();
  }

  // The first robot's first map is the root.
  void Begin(const Drive& drive) { areas_.Note(drive.first_area, graph_.root_map()); }

  // Compares all passages in the order in which they were judged.
  void Compare(const std::vector<Drive>& drives, CampusResult& result) {
    struct Judged {
      const Drive* drive;
      const json* passage;
      const json* verdict;
    };
    std::vector<Judged> all;
    for (const Drive& drive : drives) {
      for (std::size_t i = 0; i < drive.passages.size(); ++i) {
        if (i < drive.verdicts.size()) all.push_back({&drive, &drive.passages[i], &drive.verdicts[i]});
      }
      if (drive.verdicts.size() != drive.passages.size()) {
        wrong_.push_back(
            fmt::format("{}: {} verdicts on {} passages", drive.robot, drive.verdicts.size(), drive.passages.size()));
      }
    }
    std::stable_sort(all.begin(), all.end(), [](const Judged& a, const Judged& b) {
      return a.verdict->at("graph_version") < b.verdict->at("graph_version");
    });
    for (const auto& [drive, passage, verdict] : all) {
      const std::string door = passage->at("door");
      const std::string area = passage->at("to");
      const bool right = areas_.Note(area, verdict->at("entered_map")) & doors_.Note(door, verdict->at("link_point"));
      result.false_closures += right ? 0 : 1;
      result.verdicts.push_back(fmt::format("{} {} -> {}{}: {} {}", drive->robot, door, area, right ? "" : " (FALSE)",
                                            verdict->at("decision").get<std::string>(),
                                            verdict->at("reason").get<std::string>()));
    }
  }

  // `doors`: of the campus.
  void Finish(std::size_t doors, CampusResult& result) {
    std::size_t candidates = 0;
    std::size_t joining = 0;
    for (const v1::GraphLinkPoint& link_point : graph_.link_points()) {
      candidates += link_point.maps_size() == 1 ? 1 : 0;
      joining += link_point.joins() ? 1 : 0;
    }
    areas_.AddDuplicates("area", wrong_);
    doors_.AddDuplicates("door", wrong_);
    const bool all_passed = doors_.size() == doors;
    if (static_cast<std::size_t>(graph_.maps_size()) != areas_.size() || joining != doors_.size() ||
        (all_passed && candidates != 0)) {
      wrong_.push_back(fmt::format("{} areas entered, {} doors passed", areas_.size(), doors_.size()));
    }
    result.exact = wrong_.empty() && result.false_closures == 0;
    result.graph = fmt::format("{} maps, {} link points, {} candidates, {} edges{}{}", graph_.maps_size(), joining,
                               candidates, graph_.edges_size(), wrong_.empty() ? "" : ": ", fmt::join(wrong_, "; "));
  }

  void MeasurePoses(const Drive& drive, const Pose2& T_campus_world, CampusResult& result) {
    for (const json& one : drive.global_poses) {
      const Pose2 truth = TruthAt(drive, one.at("time_ns"));
      const Pose2 estimate = T_campus_world * PoseOf(one.at("pose_world_robot"));
      const std::vector<double> values = one.at("covariance");
      if (values.size() != 9) continue;
      Eigen::Matrix2d covariance;
      covariance << values[0], values[1], values[3], values[4];
      const double c = std::cos(T_campus_world.yaw);
      const double s = std::sin(T_campus_world.yaw);
      const Eigen::Matrix2d turn = (Eigen::Matrix2d() << c, -s, s, c).finished();
      const Eigen::Vector2d error = estimate.translation() - truth.translation();
      ++result.samples;
      result.inside += error.dot((turn * covariance * turn.transpose()).inverse() * error) <= kChiSquared95 ? 1 : 0;
    }
    v1::GetGlobalPoseRequest request;
    request.set_robot(graph_.site() + "/robots/" + drive.robot);
    const auto response = connection_.Call(&v1::GraphService::Stub::GetGlobalPose, request);
    if (!response.ok() || !response->global_pose().has_pose_world_robot()) {
      wrong_.push_back(drive.robot + " has no pose in the world");
      return;
    }
    const v1::GlobalPose& pose = response->global_pose();
    const v1::Pose2& world = pose.pose_world_robot().pose();
    const std::int64_t time = pose.report_time().seconds() * 1'000'000'000 + pose.report_time().nanos();
    const Pose2 truth = TruthAt(drive, time);
    const Pose2 estimate = T_campus_world * Pose2{world.x(), world.y(), world.yaw()};
    result.final_error = std::max(result.final_error, (estimate.translation() - truth.translation()).norm());
    result.final_yaw_error = std::max(result.final_yaw_error, std::abs(WrapAngle(estimate.yaw - truth.yaw)));
  }

 private:
  const client::Connection connection_;
  v1::Graph graph_;
  Names areas_;
  Names doors_;
  std::vector<std::string> wrong_;
};

// A robot's start in the frame of the map that begins with `root_robot`: X,Y,YAW.
std::string StartOf(const std::string& campus, const std::string& root_robot, const std::string& robot) {
  const auto world = std::make_shared<const simulator::World>(*simulator::ShippedCampus(campus));
  const auto start_of = [&](const std::string& name) {
    auto simulation = simulator::RobotSimulation::Start(world, name, {});
    if (!simulation.ok() || !simulation->Next().ok()) throw std::runtime_error(campus + " has no robot " + name);
    while (simulation->truth().poses.empty()) {
      if (!simulation->Next().ok()) throw std::runtime_error(name + " does not drive");
    }
    return simulation->truth().poses.front().T_campus_robot;
  };
  const Pose2 start = Between(start_of(root_robot), start_of(robot));
  return fmt::format("{},{},{}", start.x, start.y, start.yaw);
}

// Waits until the first robot's first map exists, in which the others begin.
void AwaitFirstMap(const client::Connection& connection, const std::string& site) {
  const bool exists = Eventually([&] {
    v1::GetGraphRequest request;
    request.set_site("sites/" + site);
    const auto graph = connection.Call(&v1::GraphService::Stub::GetGraph, request);
    return graph.ok() && graph->graph().maps_size() > 0;
  });
  if (!exists) throw std::runtime_error("the first robot's map does not exist");
}

}  // namespace

CampusResult RunCampus(WholeSystem& system, const CampusRun& run) {
  const std::vector<std::string>& robots = run.robots;
  const auto start = std::chrono::steady_clock::now();
  const std::string site = fmt::format("{}-{}", run.campus, run.seed);
  system.CreateSite(site);
  struct Running {
    std::string robot;
    std::filesystem::path truth;
    std::filesystem::path output;
    std::unique_ptr<Process> process;
  };
  std::vector<Running> running;
  for (const std::string& robot : robots) {
    Running one;
    one.robot = robot;
    const auto file = [&](const char* suffix) { return system.directory() / (site + "-" + robot + suffix); };
    one.truth = file(".truth.jsonl");
    one.output = file(".jsonl");
    std::vector<std::string> command = {Program("enfilade"),
                                        "--json",
                                        "--server",
                                        system.server().address(),
                                        "--site",
                                        site,
                                        "robot",
                                        "--campus",
                                        run.campus,
                                        "--robot",
                                        robot,
                                        "--seed",
                                        std::to_string(run.seed),
                                        "--spool",
                                        file(".spool").string(),
                                        "--truth",
                                        one.truth.string(),
                                        "--wait"};
    if (running.empty()) {
      command.insert(command.end(), {"--map", "M0"});
    } else {
      command.insert(command.end(), {"--on-existing-map", "M0," + StartOf(run.campus, robots[0], robot)});
    }
    one.process = std::make_unique<Process>(command, one.output);
    running.push_back(std::move(one));
    if (running.size() == 1 && robots.size() > 1) AwaitFirstMap(system.server().Connect(), site);
  }
  std::vector<Drive> drives;
  for (Running& one : running) {
    if (one.process->Wait(std::chrono::minutes(15 * kSlowdown)) != 0) throw std::runtime_error(TailOf(one.output));
    drives.push_back(ReadDrive(one.robot, one.truth, one.output));
  }
  CampusResult result;
  Judgement judgement(system.server().Connect(), site);
  const Pose2 T_campus_world = drives[0].poses.begin()->second;
  judgement.Begin(drives[0]);
  judgement.Compare(drives, result);
  for (const Drive& drive : drives) judgement.MeasurePoses(drive, T_campus_world, result);
  judgement.Finish(simulator::ShippedCampus(run.campus)->doors.size(), result);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace enfilade::testing
