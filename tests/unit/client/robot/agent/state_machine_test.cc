// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/state_machine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/client/robot/agent/door_events.h"

namespace enfilade::robot {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// One word per action, with what matters of it.
std::string WordOf(const Action& action) {
  struct {
    std::string operator()(const BeginSession& a) const {
      return a.after_passage ? "begin behind the door"
                             : "begin \"" + a.map + "\"" + (a.T_map_robot ? " at a pose" : "") +
                                   (a.locate ? " where it is located" : "");
    }
    std::string operator()(const FinishSession&) const { return "finish"; }
    std::string operator()(const KeepEvidence& a) const { return "keep " + std::to_string(a.door); }
    std::string operator()(const WriteReport& a) const {
      return (a.report.kind == sensor::DoorReport::Kind::kPassage ? "passage " : "candidate ") +
             std::to_string(a.door) + (a.report.by_hand ? " by hand" : "");
    }
    std::string operator()(const ShowMenu&) const { return "menu"; }
    std::string operator()(const ShowStatus&) const { return "status"; }
    std::string operator()(const ShowMessage&) const { return "tell"; }
    std::string operator()(const RemoveMap& a) const { return "remove map " + a.map; }
    std::string operator()(const RemoveLinkPoint& a) const { return "remove link point " + a.link_point; }
  } word;
  return std::visit(word, action);
}

// Without what is only said.
std::vector<std::string> WordsOf(const std::vector<Action>& actions) {
  std::vector<std::string> words;
  for (const Action& action : actions) {
    if (!std::holds_alternative<ShowMessage>(action)) words.push_back(WordOf(action));
  }
  return words;
}

std::string ToldBy(const std::vector<Action>& actions) {
  std::string told;
  for (const Action& action : actions) {
    if (const auto* tell = std::get_if<ShowMessage>(&action)) told += tell->text + "\n";
  }
  return told;
}

class StateMachineTest : public ::testing::Test {
 protected:
  StateMachineTest() { options_.start = RecordNewMap{"Hall"}; }

  std::vector<std::string> Do(const Event& event) {
    const std::vector<Action> actions = machine_.Handle(event);
    told_ = ToldBy(actions);
    return WordsOf(actions);
  }
  // Into kMapping, automatic.
  void StartMapping() {
    Do(Ready{});
    Do(SessionBegun{});
    Do(MovedTo(0.0, 0.0));
  }
  // Into kMainMenu, by hand.
  void StartByHand() {
    options_.automatic = false;
    machine_ = StateMachine(options_);
    Do(Ready{});
  }
  State state() const { return machine_.state(); }

  StateMachineOptions options_;
  StateMachine machine_{[this] {
    options_.start = RecordNewMap{"Hall"};
    return options_;
  }()};
  std::string told_;
};

TEST_F(StateMachineTest, BeginsByItselfWithANewMap) {
  EXPECT_EQ(state(), State::kInitialize);
  EXPECT_THAT(Do(Ready{}), ElementsAre("begin \"Hall\""));
  EXPECT_EQ(state(), State::kStartMapping);
  EXPECT_THAT(Do(SessionBegun{}), IsEmpty());
  EXPECT_EQ(state(), State::kMapping);
}

TEST_F(StateMachineTest, BeginsByItselfInAnExistingMap) {
  options_.start = MapOnExistingMap{"Hall", {}};
  machine_ = StateMachine(options_);
  EXPECT_THAT(Do(Ready{}), ElementsAre("begin \"Hall\" at a pose"));
}

TEST_F(StateMachineTest, BeginsByItselfWhereverItIs) {
  options_.start = LocateRobot{};
  machine_ = StateMachine(options_);
  EXPECT_THAT(Do(Ready{}), ElementsAre("begin \"\" where it is located"));
}

TEST_F(StateMachineTest, WhatIsInterruptedContinuesWhereTheRobotIsLocated) {
  StartMapping();
  Do(Passage(1, 5.0, 4.0, 10.0));
  EXPECT_THAT(Do(Interrupted{"odometry jumps"}), ElementsAre("finish"));
  EXPECT_THAT(Do(SessionFinished{}), ElementsAre("begin \"\" where it is located"));
  Do(SessionBegun{});
  EXPECT_THAT(Do(MovedTo(9.0, 20.0)), IsEmpty()) << "the passage before is not reported here";
}

TEST_F(StateMachineTest, KeepsWhatIsSeenAtALatchAndReportsTheCandidate) {
  StartMapping();
  EXPECT_THAT(Do(Latched(1, 1.0)), ElementsAre("keep 1"));
  EXPECT_THAT(Do(Candidate(1, 9.0, 1.0)), ElementsAre("candidate 1"));
  EXPECT_EQ(state(), State::kMapping);
}

TEST_F(StateMachineTest, ReportsAPassageOnceTheRobotIsBehindTheDoor) {
  StartMapping();
  EXPECT_THAT(Do(Passage(1, 5.0, 4.0, 10.0)), IsEmpty());
  EXPECT_THAT(Do(MovedTo(5.2, 11.9)), IsEmpty());
  const std::vector<Action> actions = machine_.Handle(MovedTo(5.4, 12.1));
  ASSERT_THAT(WordsOf(actions), ElementsAre("passage 1", "finish"));
  const sensor::DoorReport& report = std::get<WriteReport>(actions[0]).report;
  EXPECT_EQ(report.time, AfterStart(5.4));
  EXPECT_EQ(report.door_time, AfterStart(4.0));
  EXPECT_EQ(report.T_odom_door, (Pose2{10.0, 0.0, 0.0}));
  EXPECT_EQ(report.width, 1.0);
  EXPECT_EQ(report.reason, "as the test says");
  EXPECT_FALSE(report.by_hand);
  EXPECT_EQ(state(), State::kStopMapping);
  EXPECT_THAT(Do(SessionFinished{}), ElementsAre("begin behind the door"));
  EXPECT_EQ(state(), State::kStartMapping);
  EXPECT_THAT(Do(SessionBegun{}), IsEmpty());
  EXPECT_EQ(state(), State::kMapping);
}

TEST_F(StateMachineTest, ReportsAPassageAfterAWhileWhereTheRobotStaysAtTheDoor) {
  StartMapping();
  EXPECT_THAT(Do(Passage(1, 5.0, 4.0, 10.0)), IsEmpty());
  EXPECT_THAT(Do(MovedTo(6.0, 10.3)), IsEmpty());
  EXPECT_THAT(Do(MovedTo(12.9, 10.3)), IsEmpty());
  EXPECT_THAT(Do(MovedTo(13.0, 10.3)), ElementsAre("passage 1", "finish"));
}

TEST_F(StateMachineTest, GivesDoorsBehindThePassageToTheNextSession) {
  StartMapping();
  Do(Passage(1, 5.0, 4.0, 10.0));
  EXPECT_THAT(Do(Latched(2, 5.1)), ElementsAre("keep 2"));
  EXPECT_THAT(Do(Candidate(2, 5.2, 5.1)), IsEmpty());
  EXPECT_THAT(Do(Candidate(3, 5.2, 2.0)), ElementsAre("candidate 3")) << "of before the passage: this session's";
  EXPECT_THAT(Do(MovedTo(6.0, 13.0)), ElementsAre("passage 1", "finish"));
  Do(SessionFinished{});
  EXPECT_THAT(Do(SessionBegun{}), ElementsAre("candidate 2"));
}

TEST_F(StateMachineTest, ReportsAPassageAtOnceWhenTheNextDoorIsPassed) {
  StartMapping();
  Do(Passage(1, 5.0, 4.0, 10.0));
  EXPECT_THAT(Do(Passage(2, 7.0, 6.0, 11.5)), ElementsAre("passage 1", "finish"));
  EXPECT_THAT(Do(SessionFinished{}), ElementsAre("begin behind the door"));
  EXPECT_THAT(Do(SessionBegun{}), IsEmpty());
  EXPECT_THAT(Do(MovedTo(8.0, 14.0)), ElementsAre("passage 2", "finish"));
}

TEST_F(StateMachineTest, EndsWithTheSource) {
  StartMapping();
  EXPECT_THAT(Do(SourceEnded{}), ElementsAre("finish"));
  EXPECT_THAT(Do(SessionFinished{}), IsEmpty());
  EXPECT_EQ(state(), State::kEnd);
}

TEST_F(StateMachineTest, ReportsAPassageThatWaitsWhenTheSourceEnds) {
  StartMapping();
  Do(Passage(1, 5.0, 4.0, 10.0));
  EXPECT_THAT(Do(SourceEnded{}), ElementsAre("passage 1", "finish"));
  EXPECT_THAT(Do(SessionFinished{}), IsEmpty());
  EXPECT_EQ(state(), State::kEnd);
}

TEST_F(StateMachineTest, EndsWithASourceThatHasNothing) {
  Do(Ready{});
  EXPECT_THAT(Do(SourceEnded{}), ElementsAre("finish"));
  EXPECT_THAT(Do(SessionFinished{}), IsEmpty());
  EXPECT_EQ(state(), State::kEnd);
}

TEST_F(StateMachineTest, AbortFinishesWhatIsOpenAndEnds) {
  StartMapping();
  Do(Passage(1, 5.0, 4.0, 10.0));
  EXPECT_THAT(Do(Command(Abort{})), ElementsAre("finish")) << "the passage is not reported";
  EXPECT_EQ(state(), State::kAbort);
  EXPECT_THAT(Do(Passage(2, 6.0, 5.5, 12.0)), IsEmpty());
  EXPECT_THAT(Do(SessionFinished{}), IsEmpty());
  EXPECT_EQ(state(), State::kEnd);
  EXPECT_THAT(Do(Command(Abort{})), IsEmpty());
  EXPECT_EQ(state(), State::kEnd);
}

TEST_F(StateMachineTest, AbortEndsAtOnceWhereNothingIsOpen) {
  EXPECT_THAT(Do(Command(Abort{})), IsEmpty());
  EXPECT_EQ(state(), State::kEnd);
  StartByHand();
  Do(Command(Abort{}));
  EXPECT_EQ(state(), State::kEnd);
}

TEST_F(StateMachineTest, AbortBetweenTwoSessionsBeginsNoOther) {
  StartMapping();
  Do(Passage(1, 5.0, 4.0, 10.0));
  Do(MovedTo(6.0, 13.0));
  ASSERT_EQ(state(), State::kStopMapping);
  EXPECT_THAT(Do(Command(Abort{})), IsEmpty()) << "it is being finished already";
  EXPECT_THAT(Do(SessionFinished{}), IsEmpty());
  EXPECT_EQ(state(), State::kEnd);
}

TEST_F(StateMachineTest, AFailureEndsAsAnAbortDoesAndIsTold) {
  StartMapping();
  EXPECT_THAT(Do(Failed{"the disk is gone"}), ElementsAre("finish"));
  EXPECT_THAT(told_, HasSubstr("the disk is gone"));
  EXPECT_EQ(state(), State::kAbort);
}

TEST_F(StateMachineTest, StopLeadsToTheMainMenuAndOn) {
  StartMapping();
  EXPECT_THAT(Do(Command(StopMapping{})), ElementsAre("finish"));
  EXPECT_EQ(state(), State::kStopMapping);
  EXPECT_THAT(Do(SessionFinished{}), ElementsAre("menu"));
  EXPECT_EQ(state(), State::kMainMenu);
  EXPECT_THAT(Do(Latched(1, 1.0)), IsEmpty()) << "nothing is looked for in the menu";
  EXPECT_THAT(Do(Command(RecordNewMap{"Next"})), ElementsAre("begin \"Next\""));
  EXPECT_EQ(state(), State::kStartMapping);
}

TEST_F(StateMachineTest, TheMainMenuOffersAllOfIt) {
  StartByHand();
  EXPECT_EQ(state(), State::kMainMenu);
  EXPECT_THAT(Do(Command(DeleteMap{"m1"})), ElementsAre("remove map m1", "menu"));
  EXPECT_THAT(Do(Command(DeleteLinkPoint{"l1"})), ElementsAre("remove link point l1", "menu"));
  EXPECT_EQ(state(), State::kMainMenu);
  EXPECT_THAT(Do(Command(MapOnExistingMap{"m2", {}})), ElementsAre("begin \"m2\" at a pose"));
  EXPECT_EQ(state(), State::kStartMapping);
}

TEST_F(StateMachineTest, TheMainMenuEndsWithTheSource) {
  StartByHand();
  EXPECT_THAT(Do(SourceEnded{}), IsEmpty());
  EXPECT_EQ(state(), State::kEnd);
}

TEST_F(StateMachineTest, ALinkPointSetByHandEndsTheSessionAndBeginsTheNext) {
  StartByHand();
  Do(Command(RecordNewMap{"Hall"}));
  Do(SessionBegun{});
  Do(MovedTo(3.0, 7.0));
  EXPECT_THAT(Do(Command(SaveRearImage{})), ElementsAre("keep 0"));
  Do(MovedTo(6.0, 9.0));
  const std::vector<Action> actions = machine_.Handle(Command(SetLinkPoint{graph::LinkPointKind::kLift, 2}));
  ASSERT_THAT(WordsOf(actions), ElementsAre("passage 0 by hand", "finish")) << "what was saved before is used";
  const sensor::DoorReport& report = std::get<WriteReport>(actions[0]).report;
  EXPECT_EQ(report.place, graph::LinkPointKind::kLift);
  EXPECT_EQ(report.entered_level, 2);
  EXPECT_EQ(report.T_odom_door, (Pose2{9.0, 0.0, 0.0}));
  EXPECT_EQ(report.door_time, AfterStart(6.0));
  EXPECT_THAT(Do(SessionFinished{}), ElementsAre("begin behind the door"));
}

TEST_F(StateMachineTest, ACandidateSetByHandLetsTheSessionGoOn) {
  StartByHand();
  Do(Command(RecordNewMap{"Hall"}));
  Do(SessionBegun{});
  Do(MovedTo(3.0, 7.0));
  EXPECT_THAT(Do(Command(SetCandidate{})), ElementsAre("keep 0", "candidate 0 by hand"));
  EXPECT_EQ(state(), State::kMapping);
}

TEST_F(StateMachineTest, APersonsWordGoesBeforeTheDetectors) {
  StartMapping();
  Do(Passage(1, 5.0, 4.0, 10.0));
  EXPECT_THAT(Do(Command(SetLinkPoint{})), ElementsAre("keep 0", "passage 0 by hand", "finish"));
  Do(SessionFinished{});
  Do(SessionBegun{});
  EXPECT_THAT(Do(MovedTo(8.0, 14.0)), IsEmpty()) << "the detector's passage was the same one";
}

TEST_F(StateMachineTest, ByHandNothingIsTakenWithoutAPlace) {
  StartByHand();
  Do(Command(RecordNewMap{"Hall"}));
  Do(SessionBegun{});
  for (const Command& command : {Command(SetLinkPoint{}), Command(SetCandidate{}), Command(SaveRearImage{})}) {
    EXPECT_THAT(Do(command), IsEmpty());
    EXPECT_THAT(told_, HasSubstr("no scan with odometry"));
  }
  EXPECT_EQ(state(), State::kMapping);
}

TEST_F(StateMachineTest, RefusesCommandsThatAreForAnotherState) {
  for (const Command& command :
       {Command(SetLinkPoint{}), Command(SetCandidate{}), Command(SaveRearImage{}), Command(StopMapping{})}) {
    EXPECT_THAT(Do(command), IsEmpty());
    EXPECT_THAT(told_, HasSubstr("the robot is in Initialize, and this command is for Mapping"));
  }
  StartMapping();
  for (const Command& command : {Command(RecordNewMap{"x"}), Command(MapOnExistingMap{"x", {}}),
                                 Command(DeleteMap{"x"}), Command(DeleteLinkPoint{"x"})}) {
    EXPECT_THAT(Do(command), IsEmpty());
    EXPECT_THAT(told_, HasSubstr("the robot is in Mapping, and this command is for MainMenu"));
  }
  EXPECT_EQ(state(), State::kMapping);
}

TEST_F(StateMachineTest, ReportsItsStatusInEveryState) {
  EXPECT_THAT(Do(Command(AskStatus{})), ElementsAre("status"));
  StartMapping();
  EXPECT_THAT(Do(Command(AskStatus{})), ElementsAre("status"));
  Do(Command(Abort{}));
  EXPECT_THAT(Do(Command(AskStatus{})), ElementsAre("status"));
}

TEST_F(StateMachineTest, EventsOutOfTurnChangeNothing) {
  EXPECT_THAT(Do(SessionBegun{}), IsEmpty());
  EXPECT_THAT(Do(SessionFinished{}), IsEmpty());
  EXPECT_THAT(Do(Passage(1, 5.0, 4.0, 10.0)), IsEmpty());
  EXPECT_EQ(state(), State::kInitialize);
  StartMapping();
  EXPECT_THAT(Do(Ready{}), IsEmpty());
  EXPECT_THAT(Do(SessionFinished{}), IsEmpty());
  EXPECT_EQ(state(), State::kMapping);
}

TEST_F(StateMachineTest, APassageIsReportedOnceTheRobotStandsBehindTheDoor) {
  StartMapping();
  Do(MovedTo(1.0, 0.0));
  Do(Passage(1, 1.0, 1.0, 0.0));
  EXPECT_THAT(Do(MovedTo(2.0, 0.3)), IsEmpty());
  EXPECT_THAT(Do(MovedTo(4.5, 0.3)), IsEmpty()) << "it stands in the doorway";
  EXPECT_THAT(Do(MovedTo(5.0, 0.9)), IsEmpty());
  EXPECT_THAT(Do(MovedTo(6.9, 0.92)), IsEmpty());
  EXPECT_THAT(Do(MovedTo(7.1, 0.91)), ElementsAre("passage 1", "finish"));
}

}  // namespace
}  // namespace enfilade::robot
