// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <variant>
#include <vector>

#include "client/sources/log_reader.h"
#include "core/slam/mapper/log_mapper.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::slam {
namespace {

std::vector<sensor::Record> ReadLog(const std::filesystem::path& path, std::size_t limit) {
  std::vector<sensor::Record> records;
  auto reader = sources::LogReader::Open(path);
  EXPECT_OK(reader.status());
  while (reader.ok() && records.size() < limit) {
    auto entry = reader->Next();
    EXPECT_OK(entry.status());
    if (!entry.ok() || !*entry) break;
    records.push_back({static_cast<std::int64_t>(records.size()) + 1, std::move((*entry)->payload)});
  }
  return records;
}

struct Mapped {
  SlamMap map;
  grid::OccupancyGrid grid;
};

// Restores the mapper from a checkpoint after every `every` records.
Mapped MapRecords(const std::vector<sensor::Record>& records, std::size_t every, const SlamOptions& options = {}) {
  LogMapper mapper({}, options);
  Mapped mapped;
  for (std::size_t i = 0; i < records.size(); ++i) {
    mapper.Add(records[i]);
    if (i % every != every - 1) continue;
    mapped.map.Apply(mapper.TakeDelta());
    auto restored = LogMapper::Restore({}, options, mapped.map, mapper.Checkpoint());
    EXPECT_OK(restored.status());
    if (!restored.ok()) return mapped;
    mapper = *std::move(restored);
  }
  mapper.Finish();
  mapped.grid = mapper.RenderGrid();
  mapped.map.Apply(mapper.TakeDelta());
  return mapped;
}

TEST(MapperRecording, GivesTheSameMapWhereverItIsStoppedAndGoesOn) {
  ENFILADE_RECORDING_OR_SKIP(path, "laser/derived/intel_raw_odom.clf.gz");
  const std::vector<sensor::Record> records = ReadLog(path, 2400);
  const Mapped expected = MapRecords(records, records.size() + 1);
  EXPECT_GT(expected.map.loop_closures.size(), 10U);
  for (const std::size_t every : {97UL, 701UL}) {
    const Mapped actual = MapRecords(records, every);
    EXPECT_TRUE(actual.map.nodes == expected.map.nodes) << every;
    EXPECT_TRUE(actual.map.submaps == expected.map.submaps) << every;
    EXPECT_TRUE(actual.map.loop_closures == expected.map.loop_closures) << every;
    EXPECT_TRUE(actual.map.trajectory == expected.map.trajectory) << every;
    EXPECT_TRUE(actual.grid == expected.grid) << every;
  }
}

// Every fifth scan of the records: the robot moves so far in between that one match goes wrong.
std::vector<sensor::Record> EveryFifthScan(const std::vector<sensor::Record>& records, int scans) {
  std::vector<sensor::Record> sparse;
  int index = 0;
  for (const sensor::Record& record : records) {
    const bool is_scan = std::holds_alternative<sensor::LaserScan>(record.payload);
    if (is_scan && index / 5 >= scans) break;
    if (!is_scan || index % 5 == 0) sparse.push_back(record);
    if (is_scan) ++index;
  }
  return sparse;
}

// The mean error of one keyframe's position as seen from another that is near by the reference, m.
double MeanErrorOfNeighbours(const SlamMap& map, const SlamMap& reference) {
  std::map<TimeNs, Pose2> truth;
  for (const StampedPose& pose : TrajectoryOf(reference)) truth[pose.time] = pose.T_map_robot;
  double sum = 0.0;
  int pairs = 0;
  for (const auto& [i, a] : map.nodes) {
    for (const auto& [j, b] : map.nodes) {
      if (j <= i || !truth.contains(a.time) || !truth.contains(b.time)) continue;
      const Pose2 expected = Between(truth[a.time], truth[b.time]);
      if (expected.translation().norm() > 4.0) continue;
      sum += (Between(a.T_map_node, b.T_map_node).translation() - expected.translation()).norm();
      ++pairs;
    }
  }
  return pairs > 0 ? sum / pairs : 1e9;
}

// A log that ends soon after its robot has come back along a corridor. All loop closures there were rejected: a wrong
// match, believed to a centimetre, contradicts them.
TEST(MapperRecording, BelievesLoopClosuresThatAgreeMoreThanAWrongMatch) {
  ENFILADE_RECORDING_OR_SKIP(path, "laser/derived/intel_raw_odom.clf.gz");
  const std::vector<sensor::Record> records = ReadLog(path, 6000);
  const Mapped all = MapRecords(records, records.size() + 1);
  const std::vector<sensor::Record> sparse = EveryFifthScan(records, 165);
  const Mapped cut = MapRecords(sparse, sparse.size() + 1);
  const double error = MeanErrorOfNeighbours(cut.map, all.map);
  EXPECT_LT(error, 0.1);
  SlamOptions stubborn;
  stubborn.loop.min_agreeing = 10'000;
  EXPECT_GT(MeanErrorOfNeighbours(MapRecords(sparse, sparse.size() + 1, stubborn).map, all.map), 2.0 * error);
  const Mapped resumed = MapRecords(sparse, 131);
  EXPECT_TRUE(resumed.map.nodes == cut.map.nodes);
  EXPECT_TRUE(resumed.map.submaps == cut.map.submaps);
  EXPECT_TRUE(resumed.map.loop_closures == cut.map.loop_closures);
}

}  // namespace
}  // namespace enfilade::slam
