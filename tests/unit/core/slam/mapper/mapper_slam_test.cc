// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "core/slam/mapper/mapper.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/ring_of_corridors.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using testing::Drive;
using testing::kPoorOdometry;
using testing::PoseNear;
using testing::RingOfCorridors;
using testing::TwoRounds;
using testing::Wall;

struct MappedDrive {
  SlamMap map;
  grid::OccupancyGrid grid;
  std::vector<ScanReport> reports;
};

MappedDrive MapLog(const std::vector<sensor::PairedScan>& log, const SlamOptions& options = {}) {
  Mapper mapper(options);
  MappedDrive mapped;
  for (const sensor::PairedScan& scan : log) mapped.reports.push_back(mapper.AddScan(scan));
  mapper.Finish();
  mapped.grid = mapper.RenderGrid();
  mapped.map.Apply(mapper.TakeDelta());
  return mapped;
}

std::vector<sensor::PairedScan> WithoutOdometry(std::vector<sensor::PairedScan> log) {
  for (sensor::PairedScan& scan : log) scan.T_odom_robot.reset();
  return log;
}

double WorstError(const MappedDrive& mapped, const std::vector<Pose2>& truth) {
  const auto trajectory = TrajectoryOf(mapped.map);
  EXPECT_EQ(trajectory.size(), truth.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < std::min(truth.size(), trajectory.size()); ++i) {
    worst = std::max(worst, Between(Between(truth[0], truth[i]), trajectory[i].T_map_robot).translation().norm());
  }
  return worst;
}

int Accepted(const SlamMap& map) {
  int count = 0;
  for (const auto& [id, closure] : map.loop_closures) count += closure.state == LoopClosureState::kAccepted;
  return count;
}

// Accepted closures that put a keyframe more than half a metre from where it truly was, seen from its submap.
int FalseClosures(const SlamMap& map, const std::vector<Pose2>& truth) {
  std::map<std::int64_t, std::int64_t> first_sequence;  // of each submap's own keyframes
  for (const auto& [id, node] : map.nodes) first_sequence.try_emplace(node.submap, node.sequence);
  int count = 0;
  for (const auto& [id, closure] : map.loop_closures) {
    if (closure.state != LoopClosureState::kAccepted) continue;
    // A submap's origin is the pose of its first own keyframe.
    const Pose2 T_world_submap = truth.at(static_cast<std::size_t>(first_sequence.at(closure.submap) - 1));
    const Pose2 T_world_node = truth.at(static_cast<std::size_t>(map.nodes.at(closure.node).sequence - 1));
    const Pose2 off = Between(Between(T_world_submap, T_world_node), closure.T_submap_node);
    if (off.translation().norm() > 0.5 || std::abs(off.yaw) > 0.2) ++count;
  }
  return count;
}

TEST(MapperSlam, MapsARingOfCorridorsWithPoorOdometry) {
  const auto truth = TwoRounds();
  const auto log = testing::Record(RingOfCorridors(), truth, {}, kPoorOdometry, 3);
  const Pose2 drift =
      Between(Between(truth.front(), truth.back()), Between(*log.front().T_odom_robot, *log.back().T_odom_robot));
  EXPECT_GT(drift.translation().norm(), 0.5) << "the odometry alone would not do";
  const MappedDrive mapped = MapLog(log);
  EXPECT_LT(WorstError(mapped, truth), 0.15);
  EXPECT_GT(Accepted(mapped.map), 3);
  EXPECT_EQ(FalseClosures(mapped.map, truth), 0);
  for (const ScanReport& report : mapped.reports) EXPECT_FALSE(report.lost);
}

TEST(MapperSlam, MapsWithoutAnyOdometry) {
  const auto truth = TwoRounds();
  const auto log = WithoutOdometry(testing::Record(RingOfCorridors(), truth, {}, {}, 4));
  EXPECT_LT(WorstError(MapLog(log), truth), 0.2);
}

TEST(MapperSlam, MapsWithAScannerThatSeesAllAroundAndWithTheSimplifiedOccupancy) {
  const auto truth = TwoRounds();
  const auto log =
      testing::Record(RingOfCorridors(), truth, {.beams = 360, .field_of_view = 2.0 * M_PI}, kPoorOdometry, 5);
  SlamOptions options;
  options.occupancy.log_odds = false;
  EXPECT_LT(WorstError(MapLog(log, options), truth), 0.15);
}

TEST(MapperSlam, MapsALogOfKeyframesAMetreApart) {
  const auto truth = Drive({{2.5, 2.5}, {24.5, 2.5}, {24.5, 15.5}, {2.5, 15.5}, {2.5, 2.5}, {24.5, 2.5}}, 1.0);
  const auto log = testing::Record(RingOfCorridors(), truth, {}, kPoorOdometry, 6);
  EXPECT_LT(WorstError(MapLog(log), truth), 0.3);
}

TEST(MapperSlam, KnowsHowSureItsNodesAre) {
  const MappedDrive mapped = MapLog(testing::Record(RingOfCorridors(), TwoRounds(), {}, kPoorOdometry, 3));
  EXPECT_TRUE(mapped.map.nodes.at(0).covariance.isZero());
  for (const auto& [id, node] : mapped.map.nodes) {
    if (id == 0) continue;
    const Eigen::LLT<Eigen::Matrix3d> cholesky(node.covariance);
    EXPECT_EQ(cholesky.info(), Eigen::Success) << "node " << id;
    EXPECT_LT(std::sqrt(node.covariance(0, 0) + node.covariance(1, 1)), 1.0) << "node " << id;
  }
}

// The mean normalised squared error of the keyframes' poses, per degree of freedom: 1 if the covariances are right.
double MeanNees(const SlamMap& map, const std::vector<Pose2>& truth) {
  double sum = 0.0;
  for (const auto& [id, node] : map.nodes) {
    if (id == 0) continue;
    const Pose2 right = Between(truth.front(), truth[static_cast<std::size_t>(node.sequence - 1)]);
    const Eigen::Vector3d e(node.T_map_node.x - right.x, node.T_map_node.y - right.y,
                            WrapAngle(node.T_map_node.yaw - right.yaw));
    sum += e.dot(node.covariance.ldlt().solve(e)) / 3.0;
  }
  return sum / static_cast<double>(map.nodes.size() - 1);
}

TEST(MapperSlam, KnowsHowSureItIsWhateverTheScannersNoise) {
  for (const double noise : {0.003, 0.01, 0.03}) {
    double nees = 0.0;
    for (const int seed : {3, 4, 5}) {
      testing::SyntheticScanner scanner;
      scanner.range_sigma = noise;
      nees += MeanNees(MapLog(testing::Record(RingOfCorridors(), TwoRounds(), scanner, kPoorOdometry, seed)).map,
                       TwoRounds()) /
              3.0;
    }
    EXPECT_GT(nees, 0.1) << "too careful with noise of " << noise << " m";
    EXPECT_LT(nees, 3.0) << "too sure with noise of " << noise << " m";
  }
}

TEST(MapperSlam, ContinuesTheSameAfterRestoreAtAnyPoint) {
  const auto log = testing::Record(RingOfCorridors(), TwoRounds(), {}, kPoorOdometry, 3);
  const MappedDrive expected = MapLog(log);
  ASSERT_GT(Accepted(expected.map), 0);
  for (const std::size_t every : {41UL, 150UL, log.size() - 1}) {
    Mapper mapper(SlamOptions{});
    SlamMap map;
    for (std::size_t i = 0; i < log.size(); ++i) {
      if (i % every == every - 1) {
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

// As the server does: it changes the closures' state in the stored rows and finishes the map again.
SlamMap WithLoopClosures(SlamMap map, const std::string& checkpoint, LoopClosureState from, LoopClosureState to) {
  for (auto& [id, closure] : map.loop_closures) {
    if (closure.state == from) closure.state = to;
  }
  absl::StatusOr<Mapper> mapper = Mapper::Restore({}, map, checkpoint);
  EXPECT_OK(mapper);
  mapper->Finish();
  map.Apply(mapper->TakeDelta());
  return map;
}

TEST(MapperSlam, LeavesSuspendedClosuresOutUntilTheyAreResumed) {
  const auto log = testing::Record(RingOfCorridors(), TwoRounds(), {}, kPoorOdometry, 3);
  Mapper mapper(SlamOptions{});
  for (const sensor::PairedScan& scan : log) mapper.AddScan(scan);
  mapper.Finish();
  SlamMap before;
  before.Apply(mapper.TakeDelta());
  ASSERT_GT(Accepted(before), 0);
  const SlamMap suspended =
      WithLoopClosures(before, mapper.Checkpoint(), LoopClosureState::kAccepted, LoopClosureState::kSuspended);
  EXPECT_EQ(Accepted(suspended), 0);
  EXPECT_FALSE(suspended.nodes == before.nodes);
  const SlamMap resumed =
      WithLoopClosures(suspended, mapper.Checkpoint(), LoopClosureState::kSuspended, LoopClosureState::kAccepted);
  EXPECT_EQ(Accepted(resumed), Accepted(before));
  for (const auto& [id, node] : before.nodes) {
    EXPECT_THAT(resumed.nodes.at(id).T_map_node, PoseNear(node.T_map_node, 0.01, 0.001));
  }
}

TEST(MapperBadInput, AnEmptyLogGivesAnEmptyMap) {
  const MappedDrive mapped = MapLog({});
  EXPECT_TRUE(mapped.map.nodes.empty());
  EXPECT_TRUE(mapped.grid.cells.empty());
}

TEST(MapperBadInput, OneScanIsOneKeyframeAtTheOrigin) {
  const MappedDrive mapped = MapLog(testing::Record(RingOfCorridors(), {{2.5, 2.5, 0.3}}, {}, {}, 1));
  ASSERT_EQ(mapped.map.nodes.size(), 1U);
  EXPECT_EQ(mapped.map.nodes.at(0).T_map_node, Pose2{});
  EXPECT_FALSE(mapped.grid.cells.empty());
}

TEST(MapperBadInput, SaysWhyAScanOutOfRangeIsNotUsed) {
  const auto log = testing::Record({}, Drive({{0, 0}, {5, 0}}, 0.25), {}, {}, 1);  // no walls at all
  for (const ScanReport& report : MapLog(log).reports) {
    EXPECT_FALSE(report.used);
    EXPECT_THAT(report.reason, ::testing::HasSubstr("no beam"));
  }
}

TEST(MapperBadInput, FollowsTheOdometryIfNothingIsInRange) {
  // A wall to begin with, then 30 m of nothing: the scanner sees 5 m far.
  const auto truth = Drive({{0, 0}, {-30, 0}}, 0.25);
  const auto log = testing::Record({{{1, -2}, {1, 2}}, {{-1, 3}, {1, 3}}}, truth,
                                   {.beams = 360, .field_of_view = 2.0 * M_PI, .range_max = 5.0}, {}, 1);
  const MappedDrive mapped = MapLog(log);
  EXPECT_LT(WorstError(mapped, truth), 0.3);
  EXPECT_TRUE(mapped.reports.back().lost) << "the last good match is long ago";
  EXPECT_EQ(mapped.reports[1].match_age, 0.0);
  EXPECT_GT(mapped.reports.back().match_age, 30.0) << "s, of the 60 s that the drive takes";
  EXPECT_LT(mapped.reports.back().match_age, 60.0);
}

TEST(MapperBadInput, StandingStillForAnHourStaysBounded) {
  const std::vector<Pose2> still(7'200, Pose2{2.5, 2.5, 0.3});  // two scans a second
  const auto log = testing::Record(RingOfCorridors(), still, {}, {}, 2);
  Mapper mapper(SlamOptions{});
  SlamMap map;
  std::size_t early = 0;
  for (std::size_t i = 0; i < log.size(); ++i) {
    EXPECT_FALSE(mapper.AddScan(log[i]).lost);
    map.Apply(mapper.TakeDelta());
    if (i == 100) early = mapper.Checkpoint().size();
  }
  EXPECT_EQ(map.nodes.size(), 1U);
  EXPECT_LE(mapper.Checkpoint().size(), early + 64);
  EXPECT_LT(WorstError({map, {}, {}}, still), 0.02);
}

TEST(MapperBadInput, AJumpOfTheOdometryDoesNotMoveTheRobot) {
  const auto truth = TwoRounds();
  auto log = testing::Record(RingOfCorridors(), truth, {}, {}, 7);
  for (std::size_t i = 100; i < log.size(); ++i) *log[i].T_odom_robot = Pose2{4.0, -3.0, 1.0} * *log[i].T_odom_robot;
  for (std::size_t i = 200; i < log.size(); ++i) *log[i].T_odom_robot = Pose2{1e5, 2e5, 0.0} * *log[i].T_odom_robot;
  EXPECT_LT(WorstError(MapLog(log), truth), 0.2);
}

// The robot is carried from one building into another, while its wheels stand still.
struct Kidnapping {
  std::vector<Pose2> before = Drive({{2.5, 2.5}, {24.5, 2.5}, {24.5, 15.5}, {2.5, 15.5}, {2.5, 4.5}}, 0.25);
  std::vector<Pose2> truth = before;
  std::vector<sensor::PairedScan> log;

  Kidnapping() {
    auto walls = RingOfCorridors();
    for (const Wall& wall : testing::WallsFromText({"##############",  //
                                                    "#   #        #",  //
                                                    "#       ##   #",  //
                                                    "##           #",  //
                                                    "#      #     #",  //
                                                    "#  #      ####",  //
                                                    "##############"},
                                                   1.0)) {
      walls.push_back({wall.a + Eigen::Vector2d(200, 0), wall.b + Eigen::Vector2d(200, 0)});
    }
    const auto after = Drive({{201.5, 2.5}, {206.5, 1.5}, {211.5, 2.5}, {208.5, 4.5}, {203.5, 3.5}}, 0.25);
    truth.insert(truth.end(), after.begin(), after.end());
    log = testing::Record(walls, truth, {}, {}, 8);
    for (std::size_t i = before.size(); i < truth.size(); ++i) {
      log[i].T_odom_robot = *log[before.size() - 1].T_odom_robot * Between(after[0], truth[i]);
    }
  }
};

void ExpectLostAndNothingBent(const Kidnapping& kidnapping, const MappedDrive& mapped) {
  EXPECT_EQ(FalseClosures(mapped.map, kidnapping.truth), 0);
  const std::size_t at = kidnapping.before.size();
  // As if nothing had come after.
  const MappedDrive alone = MapLog({kidnapping.log.begin(), kidnapping.log.begin() + static_cast<std::ptrdiff_t>(at)});
  const auto expected = TrajectoryOf(alone.map);
  const auto trajectory = TrajectoryOf(mapped.map);
  for (std::size_t i = 0; i < at; ++i) {
    EXPECT_THAT(trajectory[i].T_map_robot, PoseNear(expected[i].T_map_robot, 0.1, 0.03)) << i;
  }
  int lost = 0;
  for (std::size_t i = at; i < kidnapping.truth.size(); ++i) lost += mapped.reports[i].lost;
  const auto after = static_cast<int>(kidnapping.truth.size() - at);
  EXPECT_GT(lost, after * 3 / 4) << "of " << after << " scans after";
  for (std::size_t i = 0; i < at; ++i) EXPECT_FALSE(mapped.reports[i].lost) << i;
}

TEST(MapperBadInput, AKidnappedRobotSaysSoAndBendsNothing) {
  const Kidnapping kidnapping;
  const MappedDrive mapped = MapLog(kidnapping.log);
  ExpectLostAndNothingBent(kidnapping, mapped);
  MappedDrive first_building = mapped;
  first_building.map.trajectory.resize(kidnapping.before.size());
  EXPECT_LT(WorstError(first_building, kidnapping.before), 0.15);
}

TEST(MapperBadInput, AKidnappedRobotWithoutOdometrySaysSoToo) {
  Kidnapping kidnapping;
  kidnapping.log = WithoutOdometry(kidnapping.log);
  ExpectLostAndNothingBent(kidnapping, MapLog(kidnapping.log));
}

// Along a bare corridor only the assumption of constant velocity shows the motion: the robot must not appear to stand.
TEST(MapperSlam, GoesOnAlongBareCorridorsWithoutOdometry) {
  const auto truth = Drive({{2.5, 2.5}, {24.5, 2.5}, {24.5, 15.5}, {2.5, 15.5}, {2.5, 4.5}}, 0.25);
  for (const std::uint64_t seed : {4, 5, 6, 7, 8, 9}) {
    const auto log = WithoutOdometry(testing::Record(RingOfCorridors(), truth, {}, {}, seed));
    EXPECT_LT(WorstError(MapLog(log), truth), 1.0) << "seed " << seed;
  }
}

// Two floors' worth of the same corridor, side by side and joined at one end: whatever is seen in one is seen in the
// other.
TEST(MapperBadInput, DoesNotTakeOneOfTwoIdenticalCorridorsForTheOther) {
  const auto walls = testing::WallsFromText({"##########################",  //
                                             "#     #     #     #      #",  //
                                             "#                        #",  //
                                             "#   #     #     #    #   #",  //
                                             "####################     #",  //
                                             "                   #     #",  //
                                             "                   #     #",  //
                                             "####################     #",  //
                                             "#     #     #     #      #",  //
                                             "#                        #",  //
                                             "#   #     #     #    #   #",  //
                                             "##########################"},
                                            1.0);
  const auto truth =
      Drive({{2.5, 2.5}, {22.5, 2.5}, {22.5, 9.5}, {2.5, 9.5}, {22.5, 9.5}, {22.5, 2.5}, {2.5, 2.5}}, 0.25);
  for (const std::uint64_t seed : {9, 10, 11}) {
    const MappedDrive mapped = MapLog(testing::Record(walls, truth, {}, kPoorOdometry, seed));
    EXPECT_EQ(FalseClosures(mapped.map, truth), 0) << "seed " << seed;
    EXPECT_LT(WorstError(mapped, truth), 0.3) << "seed " << seed;
  }
}

TEST(MapperBadInput, TakesNoScansAfterFinish) {
  Mapper mapper(SlamOptions{});
  const auto log = testing::Record(RingOfCorridors(), TwoRounds(), {}, {}, 1);
  mapper.AddScan(log[0]);
  mapper.Finish();
  EXPECT_FALSE(mapper.AddScan(log[1]).used);
}

}  // namespace
}  // namespace enfilade::slam
