// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "client/simulator/simulation.h"
#include "core/grid/overlay.h"
#include "core/slam/mapper/log_mapper.h"
#include "core/slam/state/existing_map.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using testing::PoseNear;

constexpr double kDegree = M_PI / 180.0;

// A drive through the simulated rooms, and where the robot truly was, in the frame of the drive's beginning.
struct RoomsDrive {
  std::vector<sensor::Record> records;
  std::vector<std::size_t> scans;  // of the records, which are scans
  std::vector<Pose2> truth;        // of each scan

  explicit RoomsDrive(std::uint64_t seed) {
    simulator::SimulationOptions options = simulator::RoomsOptions();
    options.seed = seed;
    const auto drive = simulator::SimulateRooms(options);
    EXPECT_OK(drive);
    for (const simulator::SimulatedRecord& entry : drive->records) {
      sensor::Record record;
      record.sequence = static_cast<std::int64_t>(records.size()) + 1;
      std::visit([&](const auto& payload) { record.payload = payload; }, entry.payload);
      if (std::holds_alternative<sensor::LaserScan>(record.payload)) scans.push_back(records.size());
      records.push_back(std::move(record));
    }
    const std::vector<simulator::TruePose>& poses = drive->truth.poses;
    for (const simulator::TruePose& pose : poses) {
      truth.push_back(Between(poses.front().T_campus_robot, pose.T_campus_robot));
    }
    EXPECT_EQ(truth.size(), scans.size());
  }

  // The last odometry not after a scan.
  std::optional<Pose2> OdometryAt(std::size_t scan) const {
    for (std::size_t i = scans.at(scan) + 1; i-- > 0;) {
      if (const auto* odometry = std::get_if<sensor::Odometry>(&records[i].payload)) return odometry->T_odom_robot;
    }
    return std::nullopt;
  }
};

struct MappedOver {
  SlamMap map;
  grid::OccupancyGrid grid;
};

// The scans from `first` on, `count` of them.
MappedOver MapPart(const RoomsDrive& drive, LogMapper mapper, std::size_t first, std::size_t count) {
  const std::size_t end = first + count < drive.scans.size() ? drive.scans[first + count] : drive.records.size();
  for (std::size_t i = drive.scans[first]; i < end; ++i) mapper.Add(drive.records[i]);
  mapper.Finish();
  MappedOver mapped;
  mapped.grid = mapper.RenderGrid();
  mapped.map.Apply(mapper.TakeDelta());
  return mapped;
}

const grid::OccupancyGrid& RoomsMap() {
  static const grid::OccupancyGrid grid = [] {
    const RoomsDrive drive(3);
    return MapPart(drive, LogMapper({}, {}), 0, drive.scans.size()).grid;
  }();
  return grid;
}

Eigen::Matrix3d Covariance(double sigma, double yaw_sigma) {
  return Eigen::Vector3d(sigma * sigma, sigma * sigma, yaw_sigma * yaw_sigma).asDiagonal();
}

int CountLoopClosures(const SlamMap& map, LoopClosureState state, std::int64_t submap) {
  int count = 0;
  for (const auto& [id, closure] : map.loop_closures) count += closure.state == state && closure.submap == submap;
  return count;
}

double WorstError(const MappedOver& mapped, const RoomsDrive& drive, std::size_t first) {
  const std::vector<StampedPose> trajectory = TrajectoryOf(mapped.map);
  double worst = 0.0;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    worst = std::max(worst, Between(drive.truth.at(first + i), trajectory[i].T_map_robot).translation().norm());
  }
  return worst;
}

// The true pose is off by up to three standard deviations, in any direction: the robot is found all the same.
TEST(MapperOnExistingMap, FindsTheRobotWhereTheEntryIsOffByUpToThreeSigma) {
  const RoomsDrive drive(17);
  const double sigma = 0.5;
  const double yaw_sigma = 12.0 * kDegree;
  const std::vector<Pose2> offsets = {{},
                                      {3 * sigma, 0, 0},
                                      {-3 * sigma, 0, 0},
                                      {0, 3 * sigma, 0},
                                      {0, -3 * sigma, 0},
                                      {0, 0, 3 * yaw_sigma},
                                      {0, 0, -3 * yaw_sigma},
                                      {1.7 * sigma, -1.7 * sigma, 1.7 * yaw_sigma}};
  std::vector<double> errors, turns;
  for (const std::size_t first : {0UL, drive.scans.size() / 3, 2 * drive.scans.size() / 3}) {
    for (const Pose2& offset : offsets) {
      const Pose2& truth = drive.truth[first];
      ExistingMap existing_map{RoomsMap(), {}};
      existing_map.entry.T_map_robot = {{truth.x + offset.x, truth.y + offset.y, truth.yaw + offset.yaw},
                                        Covariance(sigma, yaw_sigma)};
      existing_map.entry.T_odom_robot = drive.OdometryAt(first);
      const MappedOver mapped = MapPart(drive, LogMapper({}, {}, existing_map), first, 60);
      EXPECT_GT(CountLoopClosures(mapped.map, LoopClosureState::kAccepted, 0), 0);
      EXPECT_LT(WorstError(mapped, drive, first), 0.10)
          << "from scan " << first << " off by " << offset.x << " m, " << offset.y << " m, " << offset.yaw << " rad";
      const std::vector<StampedPose> trajectory = TrajectoryOf(mapped.map);
      for (std::size_t i = 0; i < trajectory.size(); ++i) {
        const Pose2 off = Between(drive.truth[first + i], trajectory[i].T_map_robot);
        errors.push_back(off.translation().norm());
        turns.push_back(std::abs(off.yaw));
      }
    }
  }
  std::sort(errors.begin(), errors.end());
  std::sort(turns.begin(), turns.end());
  EXPECT_LT(errors[errors.size() / 2], 0.05);
  EXPECT_LT(turns[turns.size() / 2], 0.5 * kDegree);
  RecordProperty("median_error_mm", static_cast<int>(1e3 * errors[errors.size() / 2]));
  RecordProperty("worst_error_mm", static_cast<int>(1e3 * errors.back()));
  RecordProperty("median_turn_mdeg", static_cast<int>(1e3 * turns[turns.size() / 2] / kDegree));
  RecordProperty("worst_turn_mdeg", static_cast<int>(1e3 * turns.back() / kDegree));
}

TEST(MapperOnExistingMap, MovesTheEntryOnByOdometryToTheFirstScan) {
  const RoomsDrive drive(17);
  const std::size_t entered = 100;
  const std::size_t first = 112;  // some 1.4 m later
  ASSERT_GT(Between(drive.truth[entered], drive.truth[first]).translation().norm(), 0.5);
  ExistingMap existing_map{{}, {{drive.truth[entered], Covariance(0.05, 0.02)}, drive.OdometryAt(entered)}};
  const MappedOver mapped = MapPart(drive, LogMapper({}, {}, existing_map), first, 5);
  EXPECT_THAT(TrajectoryOf(mapped.map).front().T_map_robot, PoseNear(drive.truth[first], 0.10, 0.10));
}

TEST(MapperOnExistingMap, RendersItsOwnLayerOnly) {
  const RoomsDrive drive(17);
  const std::size_t first = drive.scans.size() / 2;
  const ExistingMap existing_map{RoomsMap(), {{drive.truth[first], Covariance(0.1, 0.05)}, std::nullopt}};
  const MappedOver mapped = MapPart(drive, LogMapper({}, {}, existing_map), first, 3);
  const auto known = [](const grid::OccupancyGrid& grid) {
    return std::count_if(grid.cells.begin(), grid.cells.end(),
                         [](std::uint8_t cell) { return cell != grid::kUnknownCell; });
  };
  EXPECT_GT(known(mapped.grid), 1000);
  EXPECT_LT(known(mapped.grid), known(RoomsMap()) / 2) << "three scans do not see all rooms";
  ASSERT_OK_AND_ASSIGN(const grid::OccupancyGrid both, grid::Overlay(RoomsMap(), mapped.grid));
  EXPECT_GE(known(both), known(RoomsMap()));
}

// Corridors around a block, 30 m x 18 m, and another building.
std::vector<testing::Wall> Corridors() {
  return testing::WallsFromText({"##############################",  //
                                 "#    #       ##       #      #",  //
                                 "#                            #",  //
                                 "#   ###################      #",  //
                                 "#   #                 #     ##",  //
                                 "##  #                 ##     #",  //
                                 "#   #                 #      #",  //
                                 "#   ##                #      #",  //
                                 "#   #                 #   ####",  //
                                 "#   #                 #      #",  //
                                 "##  #                 ##     #",  //
                                 "#   ###################      #",  //
                                 "#                         #  #",  //
                                 "#                            #",  //
                                 "#    #      ##      #        #",  //
                                 "##############################"},
                                1.0);
}

std::vector<testing::Wall> AnotherBuilding() {
  return testing::WallsFromText({"##############################",  //
                                 "# #   #  #     #   #    #    #",  //
                                 "#   #      #      #   #   #  #",  //
                                 "#  #   # #   #  #     # #    #",  //
                                 "#    #     #  #    #     #   #",  //
                                 "# #    #     #   #   #     # #",  //
                                 "#   #    #     #   #    #    #",  //
                                 "#     #    # #    #   #   #  #",  //
                                 "##############################"},
                                1.0);
}

constexpr testing::SyntheticOdometry kOdometry{0.02, 0.02};

std::vector<Pose2> FirstRound() {
  return testing::Drive({{2.5, 2.5}, {24.5, 2.5}, {24.5, 13.5}, {2.5, 13.5}, {2.5, 2.5}}, 0.25);
}

MappedOver MapScans(Mapper mapper, const std::vector<sensor::PairedScan>& log) {
  for (const sensor::PairedScan& scan : log) mapper.AddScan(scan);
  mapper.Finish();
  MappedOver mapped;
  mapped.grid = mapper.RenderGrid();
  mapped.map.Apply(mapper.TakeDelta());
  return mapped;
}

ExistingMap CorridorsEnteredAt(const Pose2& T_map_robot, double sigma, double yaw_sigma) {
  static const grid::OccupancyGrid grid =
      MapScans(Mapper(SlamOptions{}), testing::Record(Corridors(), FirstRound(), {}, kOdometry, 3)).grid;
  return {grid, {{T_map_robot, Covariance(sigma, yaw_sigma)}, std::nullopt}};
}

TEST(MapperOnExistingMap, ContinuesTheSameAfterRestoreAtAnyPoint) {
  const auto truth = FirstRound();
  const std::vector<Pose2> way(truth.begin() + 40, truth.end());
  const auto log = testing::Record(Corridors(), way, {}, kOdometry, 5);
  Pose2 entry = Between(truth[0], way[0]);
  entry.x += 0.6;
  entry.yaw -= 0.2;
  const ExistingMap existing_map = CorridorsEnteredAt(entry, 0.4, 0.15);
  const MappedOver expected = MapScans(Mapper({}, existing_map), log);
  ASSERT_GT(CountLoopClosures(expected.map, LoopClosureState::kAccepted, 0), 1);
  for (const std::size_t every : {1UL, 37UL, log.size() - 1}) {
    Mapper mapper({}, existing_map);
    SlamMap map;
    for (std::size_t i = 0; i < log.size(); ++i) {
      if (i % every == 0 && (every > 1 || i < 30)) {
        map.Apply(mapper.TakeDelta());
        ASSERT_OK_AND_ASSIGN(mapper, Mapper::Restore({}, map, mapper.Checkpoint()));
      }
      mapper.AddScan(log[i]);
    }
    mapper.Finish();
    map.Apply(mapper.TakeDelta());
    EXPECT_TRUE(map.nodes == expected.map.nodes) << "every " << every;
    EXPECT_TRUE(map.submaps == expected.map.submaps) << "every " << every;
    EXPECT_TRUE(map.loop_closures == expected.map.loop_closures) << "every " << every;
    EXPECT_TRUE(map.trajectory == expected.map.trajectory) << "every " << every;
    EXPECT_TRUE(mapper.RenderGrid() == expected.grid) << "every " << every;
  }
}

TEST(MapperOnExistingMap, AWrongMapIsNotMatchedAndTheRowsSaySo) {
  const grid::OccupancyGrid other =
      MapScans(
          Mapper(SlamOptions{}),
          testing::Record(AnotherBuilding(), testing::Drive({{2.5, 2.5}, {6.5, 2.5}, {6.5, 4.5}, {12.5, 4.5}}, 0.25),
                          {.beams = 360, .field_of_view = 2.0 * M_PI}, kOdometry, 3))
          .grid;
  const auto way = testing::Drive({{2.5, 2.5}, {24.5, 2.5}}, 0.25);
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const auto log = testing::Record(Corridors(), way, {}, kOdometry, seed);
    const ExistingMap existing_map{other, {{Pose2{1.0, 1.0, 0.3}, Covariance(0.5, 0.2)}, std::nullopt}};
    const MappedOver mapped = MapScans(Mapper({}, existing_map), log);
    EXPECT_EQ(CountLoopClosures(mapped.map, LoopClosureState::kAccepted, 0), 0);
    ASSERT_GT(CountLoopClosures(mapped.map, LoopClosureState::kRejected, 0), 0);
    for (const auto& [id, closure] : mapped.map.loop_closures) EXPECT_NE(closure.reason, "");
    const auto trajectory = TrajectoryOf(mapped.map);
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
      EXPECT_THAT(trajectory[i].T_map_robot,
                  PoseNear(existing_map.entry.T_map_robot.pose * Between(way[0], way[i]), 0.6, 0.05))
          << "the entry alone, scan " << i;
    }
    // As unsure as the entry.
    EXPECT_GT(mapped.map.nodes.at(0).covariance(0, 0), 0.2);
  }
}

TEST(MapperOnExistingMap, AnEmptyMapIsOnlyAFrame) {
  const auto way = testing::Drive({{2.5, 2.5}, {12.5, 2.5}}, 0.25);
  const ExistingMap existing_map{{}, {{Pose2{-3.0, 7.0, 1.0}, Covariance(0.2, 0.1)}, std::nullopt}};
  const MappedOver mapped = MapScans(Mapper({}, existing_map), testing::Record(Corridors(), way, {}, kOdometry, 3));
  EXPECT_TRUE(mapped.map.loop_closures.empty());
  EXPECT_EQ(mapped.map.submaps.at(0).T_map_submap, Pose2{});
  EXPECT_THAT(TrajectoryOf(mapped.map).front().T_map_robot, PoseNear(Pose2{-3.0, 7.0, 1.0}, 1e-6, 1e-6));
}

TEST(MapperOnExistingMap, GivesTheCovarianceOfThePresentPose) {
  const auto truth = FirstRound();
  const auto log = testing::Record(Corridors(), truth, {}, kOdometry, 5);
  Mapper found({}, CorridorsEnteredAt({0.3, -0.3, 0.1}, 0.4, 0.15));
  EXPECT_EQ(found.FindPresentPose(), std::nullopt);
  Mapper alone({}, ExistingMap{{}, {{Pose2{0.3, -0.3, 0.1}, Covariance(0.4, 0.15)}, std::nullopt}});
  for (std::size_t i = 0; i < 60; ++i) {
    found.AddScan(log[i]);
    alone.AddScan(log[i]);
  }
  const auto sure = found.FindPresentPose();
  const auto unsure = alone.FindPresentPose();
  ASSERT_TRUE(sure && unsure);
  EXPECT_EQ(sure->time, log[59].scan.time);
  EXPECT_FALSE(sure->lost);
  EXPECT_THAT(sure->T_map_robot.pose, PoseNear(Between(truth[0], truth[59]), 0.1, 0.02));
  EXPECT_LT(std::sqrt(sure->T_map_robot.covariance(0, 0)), 0.15);
  EXPECT_GT(std::sqrt(unsure->T_map_robot.covariance(0, 0)), 0.39);
  EXPECT_GT(std::sqrt(unsure->T_map_robot.covariance(2, 2)), 0.149);
  // The truth lies within the stated ellipse.
  const Pose2 off = Between(Between(truth[0], truth[59]), sure->T_map_robot.pose);
  const Eigen::Vector3d e(off.x, off.y, off.yaw);
  EXPECT_LT(e.dot(sure->T_map_robot.covariance.inverse() * e), 16.3);
}

TEST(MapperOnExistingMap, KeepsItsFootprintWithinTheBounds) {
  const auto log = testing::Record(Corridors(), FirstRound(), {}, kOdometry, 5);
  Mapper mapper({}, CorridorsEnteredAt({}, 0.2, 0.1));
  const std::size_t before = mapper.footprint().kept;
  EXPECT_LT(before, 200'000U) << "30 m x 16 m, compressed";
  std::size_t nodes = 0;
  for (const sensor::PairedScan& scan : log) {
    nodes += mapper.AddScan(scan).keyframe;
    ASSERT_LT(mapper.footprint().working, 100'000'000U);
  }
  EXPECT_LT(mapper.footprint().kept, before + nodes * 1'000 + (2 + nodes / 40) * 100'000);
}

}  // namespace
}  // namespace enfilade::slam
