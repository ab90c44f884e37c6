// SPDX-License-Identifier: Apache-2.0
// Passages of a robot that rides in lifts.
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

}  // namespace
}  // namespace enfilade::robot
