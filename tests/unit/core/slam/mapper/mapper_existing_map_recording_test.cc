// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "client/sources/log_reader.h"
#include "core/slam/mapper/log_mapper.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::slam {
namespace {

std::vector<sensor::Record> ReadLog(const std::filesystem::path& path) {
  std::vector<sensor::Record> records;
  auto reader = sources::LogReader::Open(path);
  EXPECT_OK(reader.status());
  while (reader.ok()) {
    auto entry = reader->Next();
    EXPECT_OK(entry.status());
    if (!entry.ok() || !*entry) break;
    records.push_back({static_cast<std::int64_t>(records.size()) + 1, std::move((*entry)->payload)});
  }
  return records;
}

struct MappedAgain {
  SlamMap map;
  grid::OccupancyGrid grid;
};

MappedAgain MapPart(LogMapper mapper, const std::vector<sensor::Record>& records, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) mapper.Add(records[i]);
  mapper.Finish();
  MappedAgain mapped;
  mapped.grid = mapper.RenderGrid();
  mapped.map.Apply(mapper.TakeDelta());
  return mapped;
}

// A recording cut in two: the second half continues the map of the first, from a pose that is wrong by two standard
// deviations. Compared with one mapper for the whole recording.
TEST(ExistingMapRecording, TheSecondHalfContinuesTheMapOfTheFirst) {
  ENFILADE_RECORDING_OR_SKIP(path, "laser/derived/intel_raw_odom.clf.gz");
  const std::vector<sensor::Record> records = ReadLog(path);
  const std::size_t half = records.size() / 2;
  const MappedAgain whole = MapPart(LogMapper({}, {}), records, 0, records.size());
  const MappedAgain first = MapPart(LogMapper({}, {}), records, 0, half);
  ExistingMap existing_map{first.grid, {}};
  const Pose2 end = TrajectoryOf(first.map).back().T_map_robot;
  existing_map.entry.T_map_robot.pose = {end.x + 0.4, end.y - 0.4, end.yaw + 0.2};
  existing_map.entry.T_map_robot.covariance = Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal();
  const MappedAgain second = MapPart(LogMapper({}, {}, existing_map), records, half, records.size());

  int in_existing_map = 0;
  for (const auto& [id, closure] : second.map.loop_closures) {
    in_existing_map += closure.state == LoopClosureState::kAccepted && closure.submap == 0;
  }
  EXPECT_GT(in_existing_map, 20);
  const std::vector<StampedPose> expected = TrajectoryOf(whole.map);
  std::vector<double> errors, turns;
  std::size_t i = 0;
  for (const StampedPose& pose : TrajectoryOf(second.map)) {
    while (i + 1 < expected.size() && expected[i].time < pose.time) ++i;
    if (expected[i].time != pose.time) continue;
    const Pose2 off = Between(expected[i].T_map_robot, pose.T_map_robot);
    errors.push_back(off.translation().norm());
    turns.push_back(std::abs(off.yaw));
  }
  ASSERT_GT(errors.size(), 1'000U);
  std::sort(errors.begin(), errors.end());
  std::sort(turns.begin(), turns.end());
  RecordProperty("closures_in_existing_map", in_existing_map);
  RecordProperty("median_difference_mm", static_cast<int>(1e3 * errors[errors.size() / 2]));
  RecordProperty("p95_difference_mm", static_cast<int>(1e3 * errors[errors.size() * 95 / 100]));
  RecordProperty("worst_difference_mm", static_cast<int>(1e3 * errors.back()));
  RecordProperty("median_turn_mdeg", static_cast<int>(1e3 * turns[turns.size() / 2] * 180.0 / M_PI));
  EXPECT_LT(errors[errors.size() / 2], 0.15);
  EXPECT_LT(errors[errors.size() * 95 / 100], 0.5);
}

}  // namespace
}  // namespace enfilade::slam
