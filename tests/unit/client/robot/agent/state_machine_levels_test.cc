// SPDX-License-Identifier: Apache-2.0
// Passages of a robot that rides in lifts.
#include <cmath>
#include <optional>
#include <vector>

#include "client/robot/agent/state_machine.h"
#include "gtest/gtest.h"
#include "tests/unit/client/robot/agent/door_events.h"

namespace enfilade::robot {
namespace {

class StateMachineLevels : public ::testing::Test {
 protected:
  StateMachineLevels() {
    Handle(Ready{});
    Begin();
  }

  void Handle(const Event& event) {
    for (const Action& action : machine_.Handle(event)) {
      if (const auto* written = std::get_if<WriteReport>(&action)) reports_.push_back(written->report);
    }
  }

  void Begin() {
    Handle(SessionFinished{});
    Handle(SessionBegun{});
  }

  void Pass(std::int64_t number, double seconds) {
    Handle(MovedTo(seconds, 0.0));
    Handle(Passage(number, seconds, seconds, 0.0));
  }

  // Through a door at x 0 into a cabin, and to level 1 in it.
  void Ride() {
    Handle(MovedTo(1.0, -1.0));
    Handle(MovedTo(3.0, 1.5));
    Handle(Passage(1, 3.0, 2.0, 0.0));
    Handle(Command(EnterLevel{1}));
    Begin();
    Handle(MovedTo(20.0, 1.5));
  }

  // From one x to another, 0.5 m in 0.5 s at a time.
  void DriveBack(double& seconds, double from, double to) {
    for (double x = from; x >= to; x -= 0.5) Handle(MovedTo(seconds += 0.5, x));
  }

  static StateMachineOptions Options() {
    StateMachineOptions options;
    options.start = RecordNewMap{"Hall"};
    return options;
  }

  StateMachine machine_{Options()};
  std::vector<sensor::DoorReport> reports_;
};

TEST_F(StateMachineLevels, APassageLeadsToTheLevelThatTheRobotWasOnThen) {
  Pass(1, 1.0);
  Handle(Command(EnterLevel{1}));  // in the lift, before the robot is far behind its door
  ASSERT_EQ(reports_.size(), 1U) << "what the robot sees now is of another level";
  Begin();
  Pass(2, 30.0);
  Handle(MovedTo(50.0, 5.0));
  Begin();
  Pass(3, 60.0);
  Handle(MovedTo(80.0, 5.0));
  ASSERT_EQ(reports_.size(), 3U);
  EXPECT_EQ(reports_[0].entered_level, std::nullopt);
  EXPECT_EQ(reports_[1].entered_level, 1);
  EXPECT_EQ(reports_[2].entered_level, 1);
  EXPECT_EQ(reports_[0].level_time, std::nullopt);
  EXPECT_EQ(reports_[1].level_time, AfterStart(1.0)) << "the way out of the lift";
  EXPECT_EQ(reports_[2].level_time, std::nullopt);
}

// The detector may be sure of the lift's door only once the robot has left the lift.
TEST_F(StateMachineLevels, APassageThatIsSeenLateLeadsToTheLevelBefore) {
  Handle(MovedTo(10.0, 0.0));
  Handle(Command(EnterLevel{3}));
  Handle(MovedTo(20.0, 1.0));
  Handle(Command(EnterLevel{4}));
  Handle(Passage(1, 21.0, 15.0, 0.5));  // at 15 s, on level 3
  ASSERT_EQ(reports_.size(), 1U);
  EXPECT_EQ(reports_[0].entered_level, 3);
}

TEST_F(StateMachineLevels, AWayOutOfALiftThatTheDetectorMissesIsReported) {
  Ride();
  double seconds = 20.0;
  DriveBack(seconds, 1.0, -2.5);
  EXPECT_EQ(reports_.size(), 1U) << "the detector may still find the door";
  DriveBack(seconds, -3.0, -3.0);
  ASSERT_EQ(reports_.size(), 2U);
  EXPECT_EQ(reports_[1].kind, sensor::DoorReport::Kind::kPassage);
  EXPECT_EQ(reports_[1].entered_level, 1);
  EXPECT_EQ(reports_[1].door_time, AfterStart(22.0)) << "at x -0.5";
  EXPECT_EQ(reports_[0].level_time, std::nullopt);
  EXPECT_EQ(reports_[1].level_time, AfterStart(3.0));
  EXPECT_NEAR(reports_[1].T_odom_door.x, 0.0, 1e-9);
  EXPECT_NEAR(std::abs(reports_[1].T_odom_door.yaw), M_PI, 1e-9) << "it looks out of the cabin";
  EXPECT_FALSE(reports_[1].by_hand);
  Begin();
  DriveBack(seconds, -3.5, -9.0);
  EXPECT_EQ(reports_.size(), 2U) << "once";
}

TEST_F(StateMachineLevels, AWayOutOfALiftIsReportedBeforeTheNextDoor) {
  Ride();
  double seconds = 20.0;
  DriveBack(seconds, 1.0, -2.5);
  Handle(Passage(2, seconds, seconds - 0.5, -2.0));
  ASSERT_EQ(reports_.size(), 2U);
  EXPECT_NEAR(reports_[1].T_odom_door.x, 0.0, 1e-9);
  Begin();
  DriveBack(seconds, -3.0, -4.5);
  ASSERT_EQ(reports_.size(), 3U);
  EXPECT_NEAR(reports_[2].T_odom_door.x, -2.0, 1e-9);
  EXPECT_EQ(reports_[2].entered_level, 1);
}

TEST_F(StateMachineLevels, AWayOutOfALiftThatTheDetectorFindsIsReportedOnce) {
  Ride();
  double seconds = 20.0;
  DriveBack(seconds, 1.0, -1.5);
  Handle(Passage(2, seconds, 22.0, 0.1));
  DriveBack(seconds, -2.0, -2.0);
  Begin();
  DriveBack(seconds, -2.5, -9.0);
  ASSERT_EQ(reports_.size(), 2U);
  EXPECT_EQ(reports_[1].level_time, AfterStart(3.0));
}

TEST_F(StateMachineLevels, ARobotThatDrivesFarOnAnotherLevelHasLeftTheLift) {
  Handle(MovedTo(10.0, 0.0));
  Handle(Command(EnterLevel{3}));
  double seconds = 10.0;
  DriveBack(seconds, 0.0, -4.5);
  EXPECT_TRUE(reports_.empty());
  DriveBack(seconds, -5.0, -5.0);
  ASSERT_EQ(reports_.size(), 1U);
  EXPECT_EQ(reports_[0].entered_level, 3);
  EXPECT_NEAR(reports_[0].T_odom_door.x, -1.5, 1e-9);
}

}  // namespace
}  // namespace enfilade::robot
