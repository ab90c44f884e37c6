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

// Maps the log, stopping and going on from the checkpoint before the records at `restarts`.
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

TEST(LogMapper, GivesTheSameMapWhereverItIsStoppedAndGoesOn) {
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

TEST(LogMapper, RefusesBytesThatAreNoCheckpoint) {
  EXPECT_CODE(LogMapper::Restore({}, OdometryOnly(), {}, "x"), absl::StatusCode::kDataLoss);
  EXPECT_CODE(LogMapper::Restore({}, OdometryOnly(), {}, ""), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace enfilade::slam
