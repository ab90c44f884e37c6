// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/rooms/mapped_drive.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "client/simulator/simulation.h"
#include "client/simulator/simulation_files.h"
#include "core/base/status_macros.h"
#include "core/doors/door_detector.h"
#include "core/sensor/record.h"
#include "core/slam/mapper/log_mapper.h"
#include "core/slam/mapper/mapper.h"
#include "core/slam/mapper/session_chain.h"
#include "fmt/format.h"

namespace enfilade::bench {
namespace {

// What SLAM makes of the drive, and the truth at the same times.
struct Mapping {
  grid::OccupancyGrid grid;
  std::vector<slam::StampedPose> trajectory;
  std::vector<rooms::PassageHint> reported;
};

struct Passage {
  TimeNs time = 0;  // of the report
  Pose2 T_robot_door;
  double width = 0.0;
};

std::vector<Passage> DetectPassages(const std::vector<simulator::SimulatedRecord>& records) {
  std::vector<Passage> passages;
  doors::DoorDetector detector{doors::DoorOptions()};
  std::optional<Pose2> T_odom_robot;
  for (const simulator::SimulatedRecord& record : records) {
    if (const auto* odometry = std::get_if<sensor::Odometry>(&record.payload)) T_odom_robot = odometry->T_odom_robot;
    const auto* scan = std::get_if<sensor::LaserScan>(&record.payload);
    if (scan == nullptr || !T_odom_robot) continue;
    for (const doors::DoorEvent& event : detector.Add(*scan, *T_odom_robot)) {
      if (event.kind != doors::DoorEvent::Kind::kPassage) continue;
      passages.push_back({event.time, Between(event.T_odom_robot, event.T_odom_door), event.width});
    }
  }
  return passages;
}

const slam::StampedPose& PoseAt(const Mapping& mapping, TimeNs time) {
  const auto found = std::lower_bound(mapping.trajectory.begin(), mapping.trajectory.end(), time,
                                      [](const slam::StampedPose& pose, TimeNs t) { return pose.time < t; });
  return found == mapping.trajectory.end() ? mapping.trajectory.back() : *found;
}

Mapping MapAsOne(std::vector<simulator::SimulatedRecord> records) {
  slam::LogMapper mapper(sensor::ScanPairingOptions{}, slam::SlamOptions{});
  std::int64_t sequence = 0;
  for (simulator::SimulatedRecord& record : records) mapper.Add({++sequence, std::move(record.payload)});
  mapper.Finish();
  slam::SlamMap map;
  map.Apply(mapper.TakeDelta());
  return {mapper.RenderGrid(), slam::TrajectoryOf(map), {}};
}

// The scans up to time `end`, from record `next` on, as a session of their own.
slam::ChainedSession MapSession(std::vector<simulator::SimulatedRecord>& records, TimeNs end, std::size_t& next) {
  sensor::ScanPairing pairing(sensor::ScanPairingOptions{});
  std::vector<sensor::PairedScan> scans;
  for (; next < records.size(); ++next) {
    const auto* scan = std::get_if<sensor::LaserScan>(&records[next].payload);
    if (scan != nullptr && scan->time > end) break;
    pairing.Add(static_cast<std::int64_t>(next), std::move(records[next].payload), scans);
  }
  pairing.Flush(scans);
  slam::Mapper mapper(slam::SlamOptions{});
  slam::ChainedSession session;
  for (const sensor::PairedScan& scan : scans) {
    if (mapper.AddScan(scan).keyframe || &scan == &scans.back()) session.scans.push_back(scan);
  }
  mapper.Finish();
  session.map.Apply(mapper.TakeDelta());
  return session;
}

absl::StatusOr<Mapping> MapAsSessions(std::vector<simulator::SimulatedRecord> records,
                                      const std::vector<Passage>& passages) {
  slam::SessionChain chain(slam::SlamOptions{}, std::nullopt);
  std::size_t next = 0;
  for (const Passage& passage : passages) {
    ENFILADE_RETURN_IF_ERROR(chain.Append(MapSession(records, passage.time, next)));
  }
  ENFILADE_RETURN_IF_ERROR(chain.Append(MapSession(records, std::numeric_limits<TimeNs>::max(), next)));
  slam::ChainedMap map = chain.Finish();
  return Mapping{std::move(map.grid), std::move(map.trajectory), {}};
}

absl::StatusOr<Mapping> MapRecords(std::vector<simulator::SimulatedRecord> records, bool sessions) {
  const std::vector<Passage> passages = DetectPassages(records);
  Mapping mapping;
  if (sessions) {
    ENFILADE_ASSIGN_OR_RETURN(mapping, MapAsSessions(std::move(records), passages));
  } else {
    mapping = MapAsOne(std::move(records));
  }
  for (const Passage& passage : passages) {
    const Pose2 T_map_door = PoseAt(mapping, passage.time).T_map_robot * passage.T_robot_door;
    mapping.reported.push_back(rooms::PassageThrough(T_map_door, passage.width));
  }
  return mapping;
}

template <typename Value>
void Put(std::ofstream& out, const Value& value) {
  out.write(reinterpret_cast<const char*>(&value), sizeof value);
}
template <typename Value>
void Get(std::ifstream& in, Value& value) {
  in.read(reinterpret_cast<char*>(&value), sizeof value);
}

void Keep(const Mapping& mapping, const std::filesystem::path& file) {
  std::ofstream out(file, std::ios::binary);
  Put(out, mapping.grid.geometry);
  out.write(reinterpret_cast<const char*>(mapping.grid.cells.data()),
            static_cast<std::streamsize>(mapping.grid.cells.size()));
  Put(out, mapping.trajectory.size());
  for (const slam::StampedPose& pose : mapping.trajectory) Put(out, pose);
  Put(out, mapping.reported.size());
  for (const rooms::PassageHint& passage : mapping.reported) Put(out, passage);
}

bool Recall(const std::filesystem::path& file, Mapping& mapping) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return false;
  Get(in, mapping.grid.geometry);
  mapping.grid.cells.resize(mapping.grid.geometry.cell_count());
  in.read(reinterpret_cast<char*>(mapping.grid.cells.data()), static_cast<std::streamsize>(mapping.grid.cells.size()));
  std::size_t count = 0;
  Get(in, count);
  mapping.trajectory.resize(count);
  for (slam::StampedPose& pose : mapping.trajectory) Get(in, pose);
  Get(in, count);
  mapping.reported.resize(count);
  for (rooms::PassageHint& passage : mapping.reported) Get(in, passage);
  return static_cast<bool>(in);
}

const simulator::TruePose& TruthAt(const simulator::GroundTruth& truth, TimeNs time) {
  const auto found = std::lower_bound(truth.poses.begin(), truth.poses.end(), time,
                                      [](const simulator::TruePose& pose, TimeNs t) { return pose.time < t; });
  return found == truth.poses.end() ? truth.poses.back() : *found;
}

// The true place in the map's frame, as SLAM has it there: its error at that time is taken along.
Eigen::Vector2d ToMap(const Mapping& mapping, const simulator::GroundTruth& truth, TimeNs time,
                      const Eigen::Vector2d& p_campus) {
  const slam::StampedPose& pose = PoseAt(mapping, time);
  return pose.T_map_robot * (Inverse(TruthAt(truth, pose.time).T_campus_robot) * p_campus);
}

}  // namespace

absl::StatusOr<MappedDrive> MapDrive(const std::string& campus, const MappedDriveOptions& options) {
  MappedDrive mapped;
  ENFILADE_ASSIGN_OR_RETURN(mapped.campus, simulator::LoadCampus(campus));
  const simulator::Robot robot = mapped.campus.robots.front();
  mapped.level = robot.level;
  simulator::SimulationOptions simulation;
  simulation.seed = options.seed;
  simulation.laps = options.laps;
  const auto world = std::make_shared<const simulator::World>(mapped.campus);
  ENFILADE_ASSIGN_OR_RETURN(simulator::Drive drive, simulator::SimulateDrive(world, robot.id, simulation));
  Mapping mapping;
  const std::filesystem::path file =
      options.cache / fmt::format("{}-{}-{}{}.drive", std::filesystem::path(campus).filename().string(), options.seed,
                                  options.laps.value_or(robot.laps), options.sessions ? "-sessions" : "");
  if (options.cache.empty() || !Recall(file, mapping)) {
    ENFILADE_ASSIGN_OR_RETURN(mapping, MapRecords(std::move(drive.records), options.sessions));
    if (!options.cache.empty()) Keep(mapping, file);
  }
  mapped.grid = std::move(mapping.grid);
  mapped.T_campus_map = drive.truth.poses.front().T_campus_robot;
  for (const slam::StampedPose& pose : mapping.trajectory) {
    mapped.drive.push_back({pose.T_map_robot.translation(), TruthAt(drive.truth, pose.time).area});
  }
  for (const simulator::TruePassage& passage : drive.truth.passages) {
    mapped.passages.push_back(
        {ToMap(mapping, drive.truth, passage.time, passage.T_campus_robot.translation()), passage.door});
  }
  mapped.reported = std::move(mapping.reported);
  return mapped;
}

}  // namespace enfilade::bench
