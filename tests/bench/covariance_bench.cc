// SPDX-License-Identifier: Apache-2.0
// Are SLAM's covariances right? JSON on standard output:
//   bench_covariance [--buildings N] [--first-seed S] [--laps N] [--fov DEG]
//                    [--log LOG [--relations FILE | --reference FILE] [--no-odometry]]
// A drive is mapped as one map. Pairs of scans are compared with the truth: the second one's pose relative to the first
// one, its error, and its covariance by the pose graph. For a recording without a truth, every other beam is mapped on
// its own: where both mappings are right, they agree but for both their errors. (Errors that they have in common do not
// show; half the beams are less accurate than all. Published relations have errors of their own, often larger than
// SLAM's.) By the distance driven between the scans: `nees` is the mean normalised squared error divided by its degrees
// of freedom (1 is right), `inside` the share of errors within the 95 % ellipsoid (Bar-Shalom, Li, Kirubarajan 2001,
// section 5.4). `while_driving`: the robot's pose relative to its first one, as it was known at each twentieth scan, by
// the distance driven until then.

#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "client/simulator/campus/random_building.h"
#include "client/simulator/simulation.h"
#include "core/slam/loops/slam_graph.h"
#include "core/slam/mapper/mapper.h"
#include "core/slam/mapper/present_pose.h"
#include "core/slam/state/checkpoint.h"
#include "fmt/format.h"
#include "tests/bench/support/recorded_scans.h"
#include "tests/e2e/campus/trajectory_error.h"

namespace enfilade::bench {
namespace {

constexpr double kChiSquared95[] = {3.841, 5.991, 7.815};               // by degrees of freedom
constexpr std::array<double, 5> kBins = {3.0, 10.0, 30.0, 100.0, 1e9};  // m driven

struct Tally {
  int pairs = 0;
  std::array<int, 3> inside = {};  // yaw, position, pose
  std::array<double, 3> nees = {};
  double squares = 0.0;  // m^2
  double yaw_squares = 0.0;
  double variances = 0.0;  // m^2
  double yaw_variances = 0.0;

  void Add(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
    const Eigen::Vector2d p = error.head<2>();
    const std::array<double, 3> squared = {
        error.z() * error.z() / covariance(2, 2),
        p.dot(covariance.topLeftCorner<2, 2>().ldlt().solve(p)),
        error.dot(covariance.ldlt().solve(error)),
    };
    ++pairs;
    for (std::size_t k = 0; k < 3; ++k) {
      inside[k] += squared[k] <= kChiSquared95[k] ? 1 : 0;
      nees[k] += squared[k] / static_cast<double>(k + 1);
    }
    squares += p.squaredNorm();
    yaw_squares += error.z() * error.z();
    variances += covariance(0, 0) + covariance(1, 1);
    yaw_variances += covariance(2, 2);
  }

  nlohmann::json ToJson() const {
    const double n = std::max(pairs, 1);
    nlohmann::json json = {{"pairs", pairs},
                           {"error_m", std::sqrt(squares / n)},
                           {"error_deg", std::sqrt(yaw_squares / n) * 180.0 / M_PI},
                           {"sigma_m", std::sqrt(variances / n)},
                           {"sigma_deg", std::sqrt(yaw_variances / n) * 180.0 / M_PI}};
    constexpr std::array<const char*, 3> kNames = {"yaw", "position", "pose"};
    for (std::size_t k = 0; k < 3; ++k) {
      json[kNames[k]] = {{"inside", inside[k] / n}, {"nees", nees[k] / n}};
    }
    return json;
  }
};

struct Tallies {
  Tally all;
  std::array<Tally, kBins.size()> by_distance;

  void Add(double driven, const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
    const auto bin = std::find_if(kBins.begin(), kBins.end(), [&](double limit) { return driven < limit; });
    by_distance[static_cast<std::size_t>(bin - kBins.begin())].Add(error, covariance);
    all.Add(error, covariance);
  }

  nlohmann::json ToJson() const {
    nlohmann::json json = {all.ToJson()};
    json.back()["driven"] = "any";
    for (std::size_t i = 0; i < kBins.size(); ++i) {
      if (by_distance[i].pairs == 0) continue;
      const std::string name = i + 1 < kBins.size() ? fmt::format("below {} m", kBins[i]) : "farther";
      json.push_back(by_distance[i].ToJson());
      json.back()["driven"] = name;
    }
    return json;
  }
};

// Where a scan is mapped, and at which keyframe: that one's covariance is its own, too.
struct MappedScan {
  std::int64_t node = 0;
  Pose2 T_map_robot;
};

// A drive mapped as one map.
struct Mapping {
  slam::MapperState state;
  std::map<TimeNs, MappedScan> scans;
  std::vector<double> driven;  // m, up to each keyframe

  // The scan at that time, give or take 20 ms.
  const MappedScan* FindScan(TimeNs time) const {
    constexpr TimeNs kSame = kNsPerSecond / 50;
    const auto found = scans.lower_bound(time - kSame);
    return found != scans.end() && found->first <= time + kSame ? &found->second : nullptr;
  }
};

template <typename T>
T OrThrow(absl::StatusOr<T> result) {
  if (!result.ok()) throw std::runtime_error(std::string(result.status().message()));
  return *std::move(result);
}

// The robot's poses as they are known while it drives, relative to the first one.
class PresentPoses {
 public:
  PresentPoses(const std::map<TimeNs, Pose2>& truth, Tallies& tallies) : truth_(truth), tallies_(tallies) {}

  // After each scan.
  void Add(const slam::Mapper& mapper) {
    constexpr int kEvery = 20;  // scans
    const std::optional<slam::PresentPose> present = mapper.FindPresentPose();
    if (!present || present->lost) return;
    const auto truth = truth_.find(present->time);
    if (truth == truth_.end()) return;
    if (!begin_) begin_ = truth->second * Inverse(present->T_map_robot.pose);
    if (last_) driven_ += Between(*last_, truth->second).translation().norm();
    last_ = truth->second;
    if (++scans_ % kEvery != 0) return;
    const Pose2 right = Between(*begin_, truth->second);
    const Pose2& pose = present->T_map_robot.pose;
    tallies_.Add(driven_, {pose.x - right.x, pose.y - right.y, WrapAngle(pose.yaw - right.yaw)},
                 present->T_map_robot.covariance);
  }

 private:
  const std::map<TimeNs, Pose2>& truth_;
  Tallies& tallies_;
  std::optional<Pose2> begin_;  // T_campus_map
  std::optional<Pose2> last_;
  double driven_ = 0.0;
  int scans_ = 0;
};

Mapping MapScans(const std::vector<sensor::PairedScan>& scans, PresentPoses* present = nullptr) {
  const slam::SlamOptions options;
  slam::Mapper mapper(options);
  for (const sensor::PairedScan& scan : scans) {
    mapper.AddScan(scan);
    if (present != nullptr) present->Add(mapper);
  }
  mapper.Finish();
  slam::SlamMap map;
  map.Apply(mapper.TakeDelta());
  Mapping mapping;
  mapping.state = OrThrow(slam::DecodeCheckpoint(mapper.Checkpoint(), map, options.occupancy));
  for (const slam::TrajectoryPoint& point : map.trajectory) {
    const Pose2 T_map_robot = map.nodes.at(point.node).T_map_node * point.T_node_robot;
    mapping.scans.emplace(point.time, MappedScan{point.node, T_map_robot});
  }
  for (const auto& [id, node] : map.nodes) {
    const double last = mapping.driven.empty() ? 0.0 : mapping.driven.back();
    const Pose2 step = id == 0 ? Pose2{} : Between(map.nodes.at(id - 1).T_map_node, node.T_map_node);
    mapping.driven.push_back(last + step.translation().norm());
  }
  return mapping;
}

// Two scans, and the second robot pose in the first one's frame as it truly is.
struct Pair {
  MappedScan from;
  MappedScan to;
  Pose2 T_from_to;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of T_from_to
};

void Measure(const Mapping& mapping, std::vector<Pair> pairs, Tallies& tallies) {
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.from.node < b.from.node; });
  for (std::size_t begin = 0; begin < pairs.size();) {
    const std::int64_t from = pairs[begin].from.node;
    std::size_t end = begin;
    std::vector<std::int64_t> to;
    for (; end < pairs.size() && pairs[end].from.node == from; ++end) to.push_back(pairs[end].to.node);
    const auto covariances = OrThrow(slam::RelativeCovariances(mapping.state, from, to));
    for (std::size_t i = begin; i < end; ++i) {
      const Pose2 mapped = Between(pairs[i].from.T_map_robot, pairs[i].to.T_map_robot);
      const Eigen::Vector3d error(mapped.x - pairs[i].T_from_to.x, mapped.y - pairs[i].T_from_to.y,
                                  WrapAngle(mapped.yaw - pairs[i].T_from_to.yaw));
      const auto metres = [&](std::int64_t id) { return mapping.driven[static_cast<std::size_t>(id)]; };
      tallies.Add(std::abs(metres(pairs[i].to.node) - metres(from)), error,
                  covariances[i - begin] + pairs[i].covariance);
    }
    begin = end;
  }
}

// A scan whose true pose is known: `truth.node` matters only if the truth is another mapping.
struct KnownScan {
  MappedScan mapped;
  MappedScan truth;
};

std::vector<KnownScan> KnownScans(const Mapping& mapping, const std::map<TimeNs, Pose2>& truth) {
  std::vector<KnownScan> known;
  for (const auto& [time, pose] : truth) {
    if (const MappedScan* scan = mapping.FindScan(time)) known.push_back({*scan, {0, pose}});
  }
  return known;
}

// Pairs of scans at random; near ones are as likely as far ones. `other`: the mapping that stands for the truth, if it
// is one.
std::vector<Pair> ChoosePairs(const std::vector<KnownScan>& known, const Mapping* other) {
  constexpr int kFrom = 60;
  constexpr int kTo = 15;
  std::vector<Pair> pairs;
  std::mt19937_64 random(1);
  std::uniform_int_distribution<std::size_t> any(0, known.size() - 1);
  std::uniform_real_distribution<double> reach(1.0, std::log(static_cast<double>(known.size())));
  for (int i = 0; i < kFrom; ++i) {
    const KnownScan& from = known[any(random)];
    for (int k = 0; k < kTo; ++k) {
      const auto step = static_cast<std::ptrdiff_t>(std::exp(reach(random)));
      const std::ptrdiff_t to = &from - known.data() + (k % 2 == 0 ? step : -step);
      if (to < 0 || to >= std::ssize(known)) continue;
      const KnownScan& there = known[static_cast<std::size_t>(to)];
      if (there.mapped.node == from.mapped.node || (other && there.truth.node == from.truth.node)) continue;
      pairs.push_back({from.mapped, there.mapped, Between(from.truth.T_map_robot, there.truth.T_map_robot)});
      if (!other) continue;
      pairs.back().covariance =
          OrThrow(slam::RelativeCovariances(other->state, from.truth.node, {there.truth.node})).front();
    }
  }
  return pairs;
}

// Every other beam, from beam `first` on.
sensor::PairedScan HalfOf(const sensor::PairedScan& whole, std::size_t first) {
  sensor::PairedScan half = whole;
  half.scan.ranges.clear();
  for (std::size_t i = first; i < whole.scan.ranges.size(); i += 2) half.scan.ranges.push_back(whole.scan.ranges[i]);
  half.scan.angle_min += static_cast<double>(first) * whole.scan.angle_increment;
  half.scan.angle_increment *= 2.0;
  return half;
}

// Compares the mappings by both halves of the beams.
void MeasureHalves(const std::vector<sensor::PairedScan>& scans, Tallies& tallies) {
  std::array<std::vector<sensor::PairedScan>, 2> halves;
  for (const sensor::PairedScan& scan : scans) {
    for (std::size_t first : {0, 1}) halves[first].push_back(HalfOf(scan, first));
  }
  const Mapping mapping = MapScans(halves[0]);
  const Mapping other = MapScans(halves[1]);
  std::vector<KnownScan> known;
  for (const auto& [time, mapped] : mapping.scans) {
    if (const auto twin = other.scans.find(time); twin != other.scans.end()) known.push_back({mapped, twin->second});
  }
  Measure(mapping, ChoosePairs(known, &other), tallies);
}

void MeasureBuilding(std::uint64_t seed, const simulator::SimulationOptions& simulation, Tallies& tallies,
                     Tallies& present_tallies) {
  simulator::Campus campus = simulator::RandomBuilding(seed);
  const std::string robot = campus.robots.front().id;
  const auto world = std::make_shared<const simulator::World>(std::move(campus));
  simulator::SimulationOptions options = simulation;
  options.seed = seed;
  simulator::Drive drive = OrThrow(simulator::SimulateDrive(world, robot, options));
  sensor::ScanPairing pairing{sensor::ScanPairingOptions{}};
  std::vector<sensor::PairedScan> scans;
  std::int64_t sequence = 0;
  for (simulator::SimulatedRecord& record : drive.records) {
    pairing.Add(++sequence, std::move(record.payload), scans);
  }
  pairing.Flush(scans);
  std::map<TimeNs, Pose2> truth;
  for (const simulator::TruePose& pose : drive.truth.poses) truth.emplace(pose.time, pose.T_campus_robot);
  PresentPoses present(truth, present_tallies);
  const Mapping mapping = MapScans(scans, &present);
  Measure(mapping, ChoosePairs(KnownScans(mapping, truth), nullptr), tallies);
}

TimeNs TimeOf(double seconds) { return static_cast<TimeNs>(std::llround(seconds * 1e9)); }

std::vector<Pair> PairsOf(const Mapping& mapping, const std::vector<testing::Relation>& relations) {
  std::vector<Pair> pairs;
  for (const testing::Relation& relation : relations) {
    const MappedScan* from = mapping.FindScan(TimeOf(relation.time1));
    const MappedScan* to = mapping.FindScan(TimeOf(relation.time2));
    if (from && to && from->node != to->node) pairs.push_back({*from, *to, relation.T_1_2});
  }
  return pairs;
}

std::vector<Pair> PairsOf(const Mapping& mapping, const std::vector<testing::TimedPose>& reference) {
  std::map<TimeNs, Pose2> truth;
  for (const testing::TimedPose& pose : reference) truth.emplace(TimeOf(pose.time), pose.pose);
  return ChoosePairs(KnownScans(mapping, truth), nullptr);
}

void MeasureLog(const std::vector<sensor::PairedScan>& scans, const std::string& relations,
                const std::string& reference, Tallies& tallies) {
  if (relations.empty() && reference.empty()) return MeasureHalves(scans, tallies);
  const Mapping mapping = MapScans(scans);
  Measure(mapping,
          relations.empty() ? PairsOf(mapping, testing::ReadTrajectory(reference))
                            : PairsOf(mapping, testing::ReadRelations(relations)),
          tallies);
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  namespace bench = enfilade::bench;
  CLI::App app("Are SLAM's covariances right?");
  int buildings = 20;
  std::uint64_t first_seed = 7801;
  enfilade::simulator::SimulationOptions simulation;
  int laps = 0;
  double field_of_view = 0.0;
  std::string log;
  std::string relations;
  std::string reference;
  bool no_odometry = false;
  app.add_option("--buildings", buildings, "Random buildings")->capture_default_str();
  app.add_option("--first-seed", first_seed, "The first building's seed")->capture_default_str();
  app.add_option("--laps", laps, "Rounds of the route");
  app.add_option("--fov", field_of_view, "The scanner's field of view, degrees");
  app.add_option("--log", log, "A recorded log, too");
  app.add_option("--relations", relations, "Its true relations, `t1 t2 x y z roll pitch yaw`");
  app.add_option("--reference", reference, "Its true trajectory, `t x y yaw`");
  app.add_flag("--no-odometry", no_odometry, "Use the scans only");
  CLI11_PARSE(app, argc, argv);
  if (laps > 0) simulation.laps = laps;
  if (field_of_view > 0.0) simulation.scanner.field_of_view = field_of_view * M_PI / 180.0;
  try {
    nlohmann::json report;
    bench::Tallies by_truth;
    bench::Tallies present;
    for (int i = 0; i < buildings; ++i) {
      bench::MeasureBuilding(first_seed + static_cast<std::uint64_t>(i), simulation, by_truth, present);
    }
    if (buildings > 0) {
      report["buildings"] = by_truth.ToJson();
      report["while_driving"] = present.ToJson();
    }
    if (!log.empty()) {
      bench::Tallies of_log;
      bench::MeasureLog(bench::OrThrow(bench::ReadPairedScans(log, !no_odometry)), relations, reference, of_log);
      report["log"] = of_log.ToJson();
    }
    std::cout << report.dump(2) << '\n';
  } catch (const std::exception& error) {
    std::cerr << "bench_covariance: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
