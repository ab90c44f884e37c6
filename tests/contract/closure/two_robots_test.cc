// SPDX-License-Identifier: Apache-2.0
// Robots that map one campus at the same time.
#include <gmock/gmock.h>

#include <map>
#include <set>

#include "client/simulator/campus/shipped_campuses.h"
#include "client/simulator/simulation.h"
#include "tests/contract/closure/door_closures_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::SizeIs;

// Where the robot of the campus figure1 starts.
Pose2 StartOf(const std::string& robot) {
  const auto world = std::make_shared<const simulator::World>(*simulator::ShippedCampus("figure1"));
  auto simulation = simulator::RobotSimulation::Start(world, robot, {});
  while (simulation->truth().poses.empty()) EXPECT_OK(simulation->Next());
  return simulation->truth().poses.front().T_campus_robot;
}

// The order in which the robots' sessions arrive and are mapped: 1 and 2 send the next one of r1 and r2, | waits until
// all are mapped and judged.
class TwoRobots : public DoorClosuresTest, public ::testing::WithParamInterface<const char*> {
 protected:
  static const std::vector<DrivenSession>& DriveOf(int robot) {
    static std::map<int, std::vector<DrivenSession>> drives;
    std::vector<DrivenSession>& drive = drives[robot];
    if (!drive.empty()) return drive;
    DoorDriveOptions options;
    options.robot = "r" + std::to_string(robot);
    options.simulation.seed = static_cast<std::uint64_t>(robot);
    return drive = DriveThroughDoors(options);
  }
  // Sends the robot's next session.
  void SendNext(int robot) {
    std::vector<SessionId>& sessions = sent_[robot];
    const DrivenSession& driven = DriveOf(robot).at(sessions.size());
    if (!sessions.empty()) {
      sessions.push_back(Send(driven, {}, sessions.back()));
    } else if (robot == 1) {
      sessions.push_back(Send(driven, map_, {}));
    } else {
      sessions.push_back(
          Send(driven, map_, {},
               PoseWithCovariance{Between(StartOf("r1"), StartOf("r2")), graph::DefaultTransformCovariance()}));
    }
  }
  void AwaitAll() {
    for (const auto& [robot, sessions] : sent_) AwaitMapped(sessions);
  }

  std::map<int, std::vector<SessionId>> sent_;
};

// Each enters areas that the other one has mapped, through other doors. Only scans can show that; with images and
// clouds: tests/e2e/figure1_test.cc.
TEST_P(TwoRobots, ThatMapACampusTogetherMakeTheSameGraph) {
  for (const char* step = GetParam(); *step != 0; ++step) {
    if (*step == '|') {
      AwaitAll();
    } else {
      SendNext(*step - '0');
    }
  }
  AwaitAll();
  std::map<MapId, std::set<std::string>> areas;
  for (const auto& [robot, sessions] : sent_) {
    ASSERT_EQ(sessions.size(), DriveOf(robot).size());
    Decisions(sessions);
    for (std::size_t k = 0; k < sessions.size(); ++k) {
      areas[MapOf(sessions[k])].insert(k == 0 ? "M0" : DriveOf(robot)[k - 1].area);
    }
  }
  EXPECT_THAT(areas, SizeIs(4));
  for (const auto& [map, seen] : areas) EXPECT_THAT(seen, SizeIs(1)) << map.value();
  EXPECT_EQ(Value("SELECT count(*) FROM maps"), "4");
  EXPECT_EQ(Value("SELECT count(*) FROM link_points WHERE anchor_count = 2"), "5");
  EXPECT_EQ(Value("SELECT count(*) FROM link_points"), "5");
}

INSTANTIATE_TEST_SUITE_P(InAnyOrder, TwoRobots,
                         ::testing::Values("121212121212", "12|12|12|12|12|12", "1212|1212|1212", "112|12|12|12|12|2",
                                           "122|12|12|12|12|1", "22|11|12|12|12|12"));

}  // namespace
}  // namespace enfilade::testing
