// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/mapped_drive.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <memory>
#include <utility>

#include "client/simulator/campus/random_building.h"
#include "client/simulator/campus/shipped_campuses.h"
#include "client/simulator/simulation.h"
#include "core/base/status_macros.h"
#include "core/sensor/record.h"
#include "core/slam/mapper/log_mapper.h"
#include "fmt/format.h"

namespace enfilade::bench {
namespace {

absl::StatusOr<simulator::Campus> CampusOf(const std::string& name) {
  constexpr std::string_view kRandom = "random:";
  if (name.starts_with(kRandom)) return simulator::RandomBuilding(std::stoull(name.substr(kRandom.size())));
  return simulator::ShippedCampus(name);
}

// What SLAM makes of the drive, and the truth at the same times.
struct Mapping {
  grid::OccupancyGrid grid;
  std::vector<slam::StampedPose> trajectory;
};

Mapping MapRecords(std::vector<simulator::SimulatedRecord> records) {
  slam::LogMapper mapper(sensor::ScanPairingOptions{}, slam::SlamOptions{});
  std::int64_t sequence = 0;
  for (simulator::SimulatedRecord& record : records) mapper.Add({++sequence, std::move(record.payload)});
  mapper.Finish();
  slam::SlamMap map;
  map.Apply(mapper.TakeDelta());
  return {mapper.RenderGrid(), slam::TrajectoryOf(map)};
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
  const auto found = std::lower_bound(mapping.trajectory.begin(), mapping.trajectory.end(), time,
                                      [](const slam::StampedPose& pose, TimeNs t) { return pose.time < t; });
  const slam::StampedPose& pose = found == mapping.trajectory.end() ? mapping.trajectory.back() : *found;
  return pose.T_map_robot * (Inverse(TruthAt(truth, pose.time).T_campus_robot) * p_campus);
}

}  // namespace

absl::StatusOr<MappedDrive> MapDrive(const std::string& campus, std::uint64_t seed,
                                     const std::filesystem::path& cache) {
  MappedDrive mapped;
  ENFILADE_ASSIGN_OR_RETURN(mapped.campus, CampusOf(campus));
  const simulator::Robot robot = mapped.campus.robots.front();
  mapped.level = robot.level;
  simulator::SimulationOptions options;
  options.seed = seed;
  const auto world = std::make_shared<const simulator::World>(mapped.campus);
  ENFILADE_ASSIGN_OR_RETURN(simulator::Drive drive, simulator::SimulateDrive(world, robot.id, options));
  Mapping mapping;
  const std::filesystem::path file = cache / fmt::format("{}-{}.drive", campus, seed);
  if (cache.empty() || !Recall(file, mapping)) {
    mapping = MapRecords(std::move(drive.records));
    if (!cache.empty()) Keep(mapping, file);
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
  return mapped;
}

}  // namespace enfilade::bench
