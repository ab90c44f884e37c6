// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/log_mapper.h"

#include <gtest/gtest.h>

#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

SlamOptions OdometryOnly() {
  SlamOptions options;
  options.match_scans = false;
  options.close_loops = false;
  return options;
}

// A drive around a room as a log: odometry between the scans, not at their times.
std::vector<sensor::Record> Log() {
  const auto walls =
      testing::WallsFromText({"##########", "#........#", "#...##...#", "#........#", "##########"}, 2.0);
  const auto poses = testing::Drive({{3, 3}, {15, 3}, {15, 7}, {3, 7}, {3, 3}}, 0.4);
  std::vector<sensor::Record> log;
  for (sensor::PairedScan& scan : testing::Record(walls, poses, {}, {}, 1)) {
    log.push_back({0, sensor::Odometry{scan.scan.time - 10'000'000, *scan.T_odom_robot}});
    log.push_back({0, std::move(scan.scan)});
  }
  for (std::size_t i = 0; i < log.size(); ++i) log[i].sequence = static_cast<std::int64_t>(i) + 1;
  return log;
}

struct Result {
  SlamMap map;
  grid::OccupancyGrid grid;
  LogMapperCounts counts;
};

// Maps the log, restored from the checkpoint before each of the records at `restarts`.
Result MapLog(const std::vector<sensor::Record>& log, const std::vector<std::size_t>& restarts) {
  Result result;
  LogMapper mapper({}, OdometryOnly());
  for (std::size_t i = 0; i < log.size(); ++i) {
    if (std::find(restarts.begin(), restarts.end(), i) != restarts.end()) {
      result.map.Apply(mapper.TakeDelta());
      auto restored = LogMapper::Restore({}, OdometryOnly(), result.map, mapper.Checkpoint());
      EXPECT_OK(restored);
      mapper = *std::move(restored);
    }
    mapper.Add(log[i]);
  }
  mapper.Finish();
  result.map.Apply(mapper.TakeDelta());
  result.grid = mapper.RenderGrid();
  result.counts = mapper.counts();
  return result;
}

TEST(LogMapper, MapsEveryScanOfALog) {
  const auto log = Log();
  const Result result = MapLog(log, {});
  EXPECT_EQ(result.counts.used, static_cast<std::int64_t>(log.size() / 2));
  EXPECT_EQ(result.counts.pairing.paired, result.counts.used);
  EXPECT_EQ(TrajectoryOf(result.map).size(), log.size() / 2);
  EXPECT_GT(result.counts.keyframes, 10);
}

TEST(LogMapper, GivesTheSameMapWhereverItIsRestored) {
  const auto log = Log();
  const Result expected = MapLog(log, {});
  for (const std::vector<std::size_t>& restarts :
       {std::vector<std::size_t>{1}, {7, 8, 9}, {log.size() / 2}, {0, 50, 51, 90}}) {
    const Result result = MapLog(log, restarts);
    EXPECT_EQ(result.grid, expected.grid);
    EXPECT_EQ(result.map.nodes, expected.map.nodes);
    EXPECT_EQ(result.map.trajectory, expected.map.trajectory);
    EXPECT_EQ(result.counts.pairing.paired, expected.counts.pairing.paired);
  }
}

// What scans and odometry are not: the map does not depend on it.
TEST(LogMapper, IgnoresOtherRecords) {
  const auto log = Log();
  const Result expected = MapLog(log, {});
  std::vector<sensor::Record> mixed;
  for (const sensor::Record& record : log) {
    sensor::Record other = record;
    other.payload = sensor::PointCloud{};
    mixed.push_back(other);
    other.payload = sensor::Image{};
    mixed.push_back(other);
    mixed.push_back(record);
  }
  const Result result = MapLog(mixed, {});
  EXPECT_EQ(result.map.trajectory, expected.map.trajectory);
  EXPECT_EQ(result.grid, expected.grid);
  EXPECT_EQ(result.counts.used, expected.counts.used);
}

TEST(LogMapper, RestoresItsCounts) {
  const auto log = Log();
  LogMapper mapper({}, OdometryOnly());
  for (std::size_t i = 0; i < log.size() / 2; ++i) mapper.Add(log[i]);
  SlamMap map;
  map.Apply(mapper.TakeDelta());
  ASSERT_OK_AND_ASSIGN(const LogMapper restored, LogMapper::Restore({}, OdometryOnly(), map, mapper.Checkpoint()));
  const LogMapperCounts before = mapper.counts();
  const LogMapperCounts after = restored.counts();
  EXPECT_GT(before.used, 10);
  EXPECT_EQ(after.used, before.used);
  EXPECT_EQ(after.keyframes, before.keyframes);
  EXPECT_EQ(after.lost, before.lost);
  EXPECT_EQ(after.pairing.paired, before.pairing.paired);
  EXPECT_EQ(restored.Checkpoint(), mapper.Checkpoint());
}

// The checkpoint of a mapper that waits for odometry holds the scan that waits.
TEST(LogMapper, KeepsTheScanThatWaitsForOdometry) {
  const auto log = Log();
  LogMapper mapper({}, OdometryOnly());
  std::size_t i = 0;
  for (; i < 11; ++i) mapper.Add(log[i]);
  mapper.Add(log[i++]);  // a scan: its odometry, 10 ms before and 490 ms after, is not complete
  SlamMap map;
  map.Apply(mapper.TakeDelta());
  ASSERT_OK_AND_ASSIGN(LogMapper restored, LogMapper::Restore({}, OdometryOnly(), map, mapper.Checkpoint()));
  const std::int64_t used = restored.counts().used;
  restored.Finish();
  mapper.Finish();
  EXPECT_EQ(restored.counts().used, mapper.counts().used);
  EXPECT_GT(restored.counts().used, used);
}

TEST(LogMapper, RefusesADamagedCheckpoint) {
  const auto log = Log();
  LogMapper mapper({}, OdometryOnly());
  for (std::size_t i = 0; i < 30; ++i) mapper.Add(log[i]);
  SlamMap map;
  map.Apply(mapper.TakeDelta());
  const std::string checkpoint = mapper.Checkpoint();
  for (std::size_t size = 0; size < checkpoint.size(); size += 1 + size / 20) {
    EXPECT_CODE(LogMapper::Restore({}, OdometryOnly(), map, checkpoint.substr(0, size)), absl::StatusCode::kDataLoss)
        << size;
  }
  EXPECT_CODE(LogMapper::Restore({}, OdometryOnly(), map, checkpoint + "x"), absl::StatusCode::kDataLoss);
  EXPECT_CODE(LogMapper::Restore({}, OdometryOnly(), {}, checkpoint), absl::StatusCode::kDataLoss) << "other rows";
}

TEST(LogMapper, RefusesBytesThatAreNoCheckpoint) {
  EXPECT_CODE(LogMapper::Restore({}, OdometryOnly(), {}, "x"), absl::StatusCode::kDataLoss);
  EXPECT_CODE(LogMapper::Restore({}, OdometryOnly(), {}, ""), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace enfilade::slam
