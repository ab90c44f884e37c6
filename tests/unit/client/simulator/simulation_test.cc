// SPDX-License-Identifier: Apache-2.0
#include "client/simulator/simulation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "client/simulator/campus/campus_yaml.h"
#include "client/simulator/campus/random_building.h"
#include "client/simulator/campus/shipped_campuses.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"

namespace enfilade::simulator {
namespace {

using enfilade::testing::PoseNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <typename T>
std::vector<T> AllOf(const Drive& drive) {
  std::vector<T> result;
  for (const auto& record : drive.records) {
    if (const T* payload = std::get_if<T>(&record.payload)) result.push_back(*payload);
  }
  return result;
}

SimulationOptions Noiseless() {
  SimulationOptions options = RoomsOptions();
  options.laps = 1;
  options.scanner.range_sigma = options.scanner.dropout = options.wheel_sigma = options.slip = 0.0;
  return options;
}

std::shared_ptr<const World> Shipped(const std::string& name) {
  absl::StatusOr<Campus> campus = ShippedCampus(name);
  EXPECT_OK(campus.status());
  return std::make_shared<const World>(*std::move(campus));
}

TEST(Simulation, SameOptionsSameDrive) {
  SimulationOptions options = RoomsOptions();
  options.laps = 1;
  ASSERT_OK_AND_ASSIGN(const Drive first, SimulateRooms(options));
  ASSERT_OK_AND_ASSIGN(const Drive again, SimulateRooms(options));
  options.seed = 2;
  ASSERT_OK_AND_ASSIGN(const Drive other, SimulateRooms(options));
  EXPECT_EQ(AllOf<sensor::Odometry>(first), AllOf<sensor::Odometry>(again));
  EXPECT_NE(AllOf<sensor::Odometry>(first), AllOf<sensor::Odometry>(other));
  EXPECT_EQ(first.truth.poses.size(), other.truth.poses.size()) << "noise must not change the way";
}

TEST(Simulation, NoSensorChangesWhatAnotherReads) {
  const auto world = Shipped("figure1");
  SimulationOptions options;
  options.scan_hz = 1.0;
  ASSERT_OK_AND_ASSIGN(RobotSimulation alone, RobotSimulation::Start(world, "r1", options));
  options.cloud_hz = 2.0;
  options.image_hz = 1.0;
  options.camera.width = 32;
  options.camera.height = 24;
  ASSERT_OK_AND_ASSIGN(RobotSimulation other, RobotSimulation::Start(world, "r2", options));
  ASSERT_OK_AND_ASSIGN(RobotSimulation together, RobotSimulation::Start(world, "r1", options));
  for (int i = 0; i < 100; ++i) {
    ASSERT_OK_AND_ASSIGN(const auto expected, alone.Next());
    ASSERT_OK(other.Next().status());
    while (true) {
      ASSERT_OK_AND_ASSIGN(const auto record, together.Next());
      ASSERT_TRUE(record.has_value());
      if (record->payload.index() >= 2) continue;  // an image or a cloud
      const sensor::Record a{1, expected->payload};
      const sensor::Record b{1, record->payload};
      ASSERT_EQ(sensor::TimeOf(a), sensor::TimeOf(b));
      if (std::holds_alternative<sensor::Odometry>(a.payload)) {
        ASSERT_EQ(a, b);
      }
      break;
    }
  }
}

TEST(Simulation, RecordsAreValidAndInTheOrderOfTime) {
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateRooms(RoomsOptions()));
  TimeNs last = 0;
  std::int64_t sequence = 0;
  for (const auto& entry : drive.records) {
    const sensor::Record record{++sequence, entry.payload};
    ASSERT_OK(sensor::Validate(record));
    ASSERT_GE(sensor::TimeOf(record), last);
    last = sensor::TimeOf(record);
  }
  const auto scans = AllOf<sensor::LaserScan>(drive);
  ASSERT_EQ(scans.size(), drive.truth.poses.size());
  EXPECT_EQ(scans.back().time, drive.truth.poses.back().time);
  EXPECT_NEAR(static_cast<double>(AllOf<sensor::Odometry>(drive).size()) / static_cast<double>(scans.size()), 4.0, 0.1);
}

TEST(Simulation, TheSecondLapSeesTheSamePlaces) {
  SimulationOptions options = Noiseless();
  options.laps = 2;
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateRooms(options));
  const TruePose& half_way = drive.truth.poses[drive.truth.poses.size() / 2];
  EXPECT_LT((half_way.T_campus_robot.translation() - drive.truth.poses.back().T_campus_robot.translation()).norm(),
            1.0);
}

TEST(Simulation, WithoutNoiseOdometryIsTheTruth) {
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateRooms(Noiseless()));
  const Pose2 T_campus_start = drive.truth.poses.front().T_campus_robot;
  std::size_t checked = 0;
  for (const sensor::Odometry& odometry : AllOf<sensor::Odometry>(drive)) {
    if (checked == drive.truth.poses.size() || odometry.time != drive.truth.poses[checked].time) continue;
    ASSERT_THAT(T_campus_start * odometry.T_odom_robot,
                PoseNear(drive.truth.poses[checked].T_campus_robot, 1e-9, 1e-9));
    ++checked;
  }
  EXPECT_EQ(checked, drive.truth.poses.size());
}

TEST(Simulation, WithNoiseOdometryDrifts) {
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateRooms(RoomsOptions()));
  const Pose2 by_wheels = drive.truth.poses.front().T_campus_robot * AllOf<sensor::Odometry>(drive).back().T_odom_robot;
  const double error = Between(by_wheels, drive.truth.poses.back().T_campus_robot).translation().norm();
  EXPECT_GT(error, 0.3);
  EXPECT_LT(error, 20.0);
}

TEST(Simulation, ReportsThePassagesOfFigure1InTheOrderOfEvents) {
  SimulationOptions options;
  options.scan_hz = 1.0;
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateDrive(Shipped("figure1"), "r1", options));
  std::vector<std::string> doors;
  std::vector<std::string> areas = {drive.truth.poses.front().area};
  for (const TruePassage& passage : drive.truth.passages) {
    doors.push_back(passage.door);
    EXPECT_EQ(passage.from, areas.back());
    areas.push_back(passage.to);
    EXPECT_LT(passage.incidence, 0.3);
  }
  EXPECT_THAT(doors, ElementsAre("L0", "L1", "L2", "L3", "L4"));
  EXPECT_THAT(areas, ElementsAre("M0", "M1", "M2", "M3", "M0", "M2"));
  EXPECT_EQ(drive.truth.poses.back().area, "M2");
}

TEST(Simulation, ALiftChangesTheLevel) {
  ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateDrive(Shipped("levels"), "r1", {}));
  EXPECT_EQ(drive.truth.poses.front().level, "ground");
  EXPECT_EQ(drive.truth.poses.back().level, "first");
  EXPECT_EQ(drive.truth.poses.back().area, "office");
  // While it rides the cabin is closed: nothing is farther than its walls.
  const auto scans = AllOf<sensor::LaserScan>(drive);
  bool enclosed = false;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (drive.truth.poses[i].area != "lift") continue;
    float farthest = 0.0F;
    for (const float range : scans[i].ranges) farthest = std::isnan(range) ? farthest : std::max(farthest, range);
    enclosed = enclosed || farthest < 2.0F;
  }
  EXPECT_TRUE(enclosed);
}

TEST(Simulation, EveryShippedCampusIsDriven) {
  SimulationOptions options;
  options.scan_hz = 1.0;
  for (const std::string& name : ShippedCampusNames()) {
    const auto world = Shipped(name);
    ASSERT_FALSE(world->campus().robots.empty()) << name;
    for (const Robot& robot : world->campus().robots) {
      ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateDrive(world, robot.id, options));
      EXPECT_FALSE(drive.truth.passages.empty()) << name << " " << robot.id;
      for (const TruePose& pose : drive.truth.poses) ASSERT_NE(pose.area, "") << name << " " << robot.id;
    }
  }
}

TEST(Simulation, RandomBuildingsAreTheSameForTheSameSeedAndAreDriven) {
  SimulationOptions options;
  options.scan_hz = 0.5;
  for (std::uint64_t seed = 900; seed < 920; ++seed) {
    const auto world = std::make_shared<const World>(RandomBuilding(seed));
    ASSERT_OK(Validate(world->campus()));
    ASSERT_OK_AND_ASSIGN(const Drive drive, SimulateDrive(world, "robot", options));
    ASSERT_OK_AND_ASSIGN(const Drive again,
                         SimulateDrive(std::make_shared<const World>(RandomBuilding(seed)), "robot", options));
    EXPECT_GT(drive.truth.passages.size(), 4U) << seed;
    EXPECT_EQ(AllOf<sensor::Odometry>(drive), AllOf<sensor::Odometry>(again));
    for (const TruePassage& passage : drive.truth.passages) {
      EXPECT_GE(passage.width, 0.7 - 1e-9);
      EXPECT_LE(passage.width, 2.0 + 1e-9);
    }
  }
}

TEST(Simulation, RefusesBadOptionsAndRoutes) {
  SimulationOptions options = RoomsOptions();
  options.laps = 0;
  EXPECT_STATUS(SimulateRooms(options), absl::StatusCode::kInvalidArgument, HasSubstr("laps is 0"));
  options = {};
  options.motion.speed = NAN;
  EXPECT_STATUS(SimulateRooms(options), absl::StatusCode::kInvalidArgument, HasSubstr("speed"));
  EXPECT_STATUS(SimulateDrive(Shipped("rooms"), "nobody", {}), absl::StatusCode::kNotFound, HasSubstr("nobody"));
  ASSERT_OK_AND_ASSIGN(Campus walled, ParseCampus(R"(
areas: [{id: a, rect: [0, 0, 4, 4]}, {id: b, rect: [4, 0, 4, 4], doors: [{id: d, side: west, state: closed}]}]
robots: [{id: r, route: [[1, 2], {door: d}]}])"));
  EXPECT_STATUS(SimulateDrive(std::make_shared<const World>(std::move(walled)), "r", {}),
                absl::StatusCode::kFailedPrecondition, HasSubstr("into a wall"));
}

}  // namespace
}  // namespace enfilade::simulator
