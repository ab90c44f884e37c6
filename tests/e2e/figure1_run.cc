#include "tests/e2e/figure1_run.h"

#include <Eigen/LU>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <stdexcept>

#include "client/simulator/campus_yaml.h"
#include "client/simulator/simulation.h"
#include "core/geometry/pose2.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "fmt/format.h"
#include "fmt/ranges.h"
#include "nlohmann/json.hpp"

namespace enfilade::testing {
namespace {

using nlohmann::json;

constexpr double kChiSquared95 = 5.991;  // 2 degrees of freedom
constexpr std::size_t kMaps = 4;
constexpr std::size_t kDoors = 5;

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

// One robot's drive: the truth, and what it was told.
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

class Judgement {
 public:
  Judgement(const Connection& connection, const std::string& site) : connection_(connection) {
    v1::GetGraphRequest request;
    request.set_site("sites/" + site);
    const auto response = connection_.Call(&v1::GraphService::Stub::GetGraph, request);
    if (!response.ok()) throw std::runtime_error("GetGraph: " + response.status().ToString());
    graph_ = response->graph();
  }

  // The areas of the campus and the maps that stand for them; the doors and their link points.
  void Compare(const Drive& drive, Figure1Result& result) {
    // The first robot's first map is the root.
    Note(areas_, drive.first_area, graph_.root_map(), "area");
    for (std::size_t i = 0; i < drive.passages.size(); ++i) {
      const std::string door = drive.passages[i].at("door");
      const std::string to = drive.passages[i].at("to");
      if (i >= drive.verdicts.size()) {
        wrong_.push_back(fmt::format("{}: no verdict on {}", drive.robot, door));
        continue;
      }
      const json& verdict = drive.verdicts[i];
      const bool known = verdict.at("decision") == "DECISION_CANDIDATE_PROMOTED" ||
                         verdict.at("decision") == "DECISION_LINK_POINT_RECOGNISED";
      const bool right =
          Note(areas_, to, verdict.at("entered_map"), "area") & Note(doors_, door, verdict.at("link_point"), "door");
      if (known && !right) ++result.false_closures;
    }
  }

  void Finish(Figure1Result& result) {
    std::size_t candidates = 0;
    std::size_t joining = 0;
    for (const v1::GraphLinkPoint& link_point : graph_.link_points()) {
      candidates += link_point.maps_size() == 1 ? 1 : 0;
      joining += link_point.joins() ? 1 : 0;
    }
    if (static_cast<std::size_t>(graph_.maps_size()) != kMaps || joining != kDoors || candidates != 0) {
      wrong_.emplace_back("not 4 maps, 5 link points, no candidate");
    }
    result.exact = wrong_.empty();
    result.graph = fmt::format("{} maps, {} link points, {} candidates, {} edges{}{}", graph_.maps_size(), joining,
                               candidates, graph_.edges_size(), wrong_.empty() ? "" : ": ", fmt::join(wrong_, "; "));
  }

  void MeasurePoses(const Drive& drive, const Pose2& T_campus_world, Figure1Result& result) {
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
  // Remembers that `true_name` is `name`; false where one of them is another already.
  bool Note(std::map<std::string, std::string>& names, const std::string& true_name, const std::string& name,
            const char* what) {
    const auto known = names.emplace(true_name, name).first;
    bool right = known->second == name;
    for (const auto& [other_true, other] : names) right = right && (other_true == true_name || other != name);
    if (!right) wrong_.push_back(fmt::format("{} {} is {}", what, true_name, name.substr(name.rfind('/') + 1)));
    return right;
  }

  const Connection connection_;
  v1::Graph graph_;
  std::map<std::string, std::string> areas_;
  std::map<std::string, std::string> doors_;
  std::vector<std::string> wrong_;
};

// Where a robot begins, in the frame of the map that begins with `root_robot`: X,Y,YAW.
std::string StartOf(const std::string& root_robot, const std::string& robot) {
  const auto world = std::make_shared<const simulator::World>(*simulator::ShippedCampus("figure1"));
  const auto start_of = [&](const std::string& name) {
    auto simulation = simulator::RobotSimulation::Start(world, name, {});
    if (!simulation.ok() || !simulation->Next().ok()) throw std::runtime_error("figure1 has no robot " + name);
    while (simulation->truth().poses.empty()) {
      if (!simulation->Next().ok()) throw std::runtime_error(name + " does not drive");
    }
    return simulation->truth().poses.front().T_campus_robot;
  };
  const Pose2 start = Between(start_of(root_robot), start_of(robot));
  return fmt::format("{},{},{}", start.x, start.y, start.yaw);
}

// Until the first robot has been judged in its third map: both doors that it saw from inside are candidates then. A
// robot that enters an area by a door that nobody has seen, while another enters it by another door, begins a second
// map of it: no door tells that the two are one.
void AwaitCandidates(const Connection& connection, const std::string& site) {
  constexpr int kCandidates = 2;
  const bool there = Eventually(
      [&] {
        v1::GetGraphRequest request;
        request.set_site("sites/" + site);
        const auto graph = connection.Call(&v1::GraphService::Stub::GetGraph, request);
        int candidates = 0;
        if (graph.ok()) {
          for (const v1::GraphLinkPoint& one : graph->graph().link_points()) candidates += one.maps_size() == 1 ? 1 : 0;
        }
        return candidates >= kCandidates;
      },
      std::chrono::seconds(180));
  if (!there) throw std::runtime_error("the first robot's candidates are not there");
}

}  // namespace

Figure1Result RunFigure1(WholeSystem& system, std::uint64_t seed, const std::vector<std::string>& robots) {
  const auto start = std::chrono::steady_clock::now();
  const std::string site = fmt::format("seed-{}", seed);
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
                                        "figure1",
                                        "--robot",
                                        robot,
                                        "--seed",
                                        std::to_string(seed),
                                        "--spool",
                                        file(".spool").string(),
                                        "--truth",
                                        one.truth.string(),
                                        "--wait"};
    if (running.empty()) {
      command.insert(command.end(), {"--map", "M0"});
    } else {
      command.insert(command.end(), {"--on-old-map", "M0," + StartOf(robots[0], robot)});
    }
    one.process = std::make_unique<Process>(command, one.output);
    running.push_back(std::move(one));
    if (running.size() < robots.size()) AwaitCandidates(system.server().Connect(), site);
  }
  std::vector<Drive> drives;
  for (Running& one : running) {
    if (one.process->Wait(std::chrono::minutes(15)) != 0) throw std::runtime_error(TailOf(one.output));
    drives.push_back(ReadDrive(one.robot, one.truth, one.output));
  }
  Figure1Result result;
  Judgement judgement(system.server().Connect(), site);
  const Pose2 T_campus_world = drives[0].poses.begin()->second;
  for (const Drive& drive : drives) {
    judgement.Compare(drive, result);
    judgement.MeasurePoses(drive, T_campus_world, result);
  }
  judgement.Finish(result);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace enfilade::testing
