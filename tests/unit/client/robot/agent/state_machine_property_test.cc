// SPDX-License-Identifier: Apache-2.0
// The state machine as a whole: which command is possible in which state, and what holds in every sequence of events.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "client/robot/agent/state_machine.h"

namespace enfilade::robot {
namespace {

StateMachineOptions OptionsFor(bool automatic) {
  StateMachineOptions options;
  options.automatic = automatic;
  options.start = RecordNewMap{"Hall"};
  return options;
}

// A machine that was brought into `state`, with a pose if it is recording.
StateMachine MachineIn(State state) {
  StateMachine machine(OptionsFor(false));
  if (state == State::kInitialize) return machine;
  machine.Handle(Ready{});  // kMainMenu
  if (state == State::kMainMenu) return machine;
  machine.Handle(Command(RecordNewMap{"Hall"}));
  if (state == State::kStartMapping) return machine;
  machine.Handle(SessionBegun{});
  machine.Handle(Moved{kNsPerSecond, {1.0, 0.0, 0.0}});
  if (state == State::kMapping) return machine;
  machine.Handle(state == State::kStopMapping ? Command(StopMapping{}) : Command(Abort{}));
  if (state == State::kEnd) machine.Handle(SessionFinished{});
  return machine;
}

constexpr State kStates[] = {State::kInitialize, State::kStartMapping, State::kMapping, State::kStopMapping,
                             State::kMainMenu,   State::kAbort,        State::kEnd};

TEST(StateMachineStates, AreReachedAndHaveNamesOfTheirOwn) {
  std::vector<std::string> names;
  for (const State state : kStates) {
    EXPECT_EQ(MachineIn(state).state(), state) << NameOf(state);
    names.emplace_back(NameOf(state));
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::unique(names.begin(), names.end()), names.end());
}

struct CommandRow {
  const char* name;
  Command command;
  State allowed_in;
  State leads_to;
};

const CommandRow kCommands[] = {
    {"new", RecordNewMap{"m"}, State::kMainMenu, State::kStartMapping},
    {"existing", MapOnExistingMap{"m", {}}, State::kMainMenu, State::kStartMapping},
    {"delete map", DeleteMap{"m"}, State::kMainMenu, State::kMainMenu},
    {"delete link point", DeleteLinkPoint{"l"}, State::kMainMenu, State::kMainMenu},
    {"set link point", SetLinkPoint{}, State::kMapping, State::kStopMapping},
    {"save rear image", SaveRearImage{}, State::kMapping, State::kMapping},
    {"set candidate", SetCandidate{}, State::kMapping, State::kMapping},
    {"stop", StopMapping{}, State::kMapping, State::kStopMapping},
};

TEST(StateMachineStates, TakeTheirCommandsAndRefuseTheOthersWithAMessage) {
  for (const CommandRow& row : kCommands) {
    for (const State state : kStates) {
      StateMachine machine = MachineIn(state);
      const std::vector<Action> actions = machine.Handle(row.command);
      const std::string where = std::string(row.name) + " in " + NameOf(state);
      if (state == row.allowed_in) {
        EXPECT_EQ(machine.state(), row.leads_to) << where;
        EXPECT_FALSE(actions.empty()) << where;
        continue;
      }
      EXPECT_EQ(machine.state(), state) << where;
      ASSERT_EQ(actions.size(), 1U) << where;
      const auto* message = std::get_if<ShowMessage>(&actions[0]);
      ASSERT_NE(message, nullptr) << where;
      EXPECT_NE(message->text.find(std::string("the robot is in ") + NameOf(state)), std::string::npos) << where;
      EXPECT_NE(message->text.find(std::string("for ") + NameOf(row.allowed_in)), std::string::npos) << where;
    }
  }
}

TEST(StateMachineStates, AbortAlwaysLeadsToTheEndAndFinishesAnOpenSession) {
  for (const State state : kStates) {
    StateMachine machine = MachineIn(state);
    const std::vector<Action> actions = machine.Handle(Command(Abort{}));
    const bool open = state == State::kStartMapping || state == State::kMapping;
    EXPECT_EQ(std::count_if(actions.begin(), actions.end(),
                            [](const Action& action) { return std::holds_alternative<FinishSession>(action); }),
              open ? 1 : 0)
        << NameOf(state);
    const bool waits = open || state == State::kStopMapping || state == State::kAbort;
    EXPECT_EQ(machine.state(), waits ? State::kAbort : State::kEnd) << NameOf(state);
    machine.Handle(SessionFinished{});
    EXPECT_EQ(machine.state(), State::kEnd) << NameOf(state);
  }
}

TEST(StateMachineStates, TheEndOfTheSourceAlwaysLeadsToTheEnd) {
  for (const State state : kStates) {
    StateMachine machine = MachineIn(state);
    machine.Handle(SourceEnded{});
    machine.Handle(SessionFinished{});
    EXPECT_EQ(machine.state(), State::kEnd) << NameOf(state);
  }
}

// Handles the actions as an agent does, and checks that they come in an order that it can execute.
class Harness {
 public:
  explicit Harness(bool automatic) : machine_(OptionsFor(automatic)) { Send(Ready{}); }

  void Send(const Event& event) {
    queue_.push_back(event);
    while (!queue_.empty()) {
      const Event next = queue_.front();
      queue_.pop_front();
      for (const Action& action : machine_.Handle(next)) std::visit([this](const auto& one) { Check(one); }, action);
    }
  }
  // Executes what the agent would do later: with the next scan, or when the spool has finished the session.
  void Answer() {
    if (begun_later_) {
      begun_later_ = false;
      open_ = true;
      ++sessions;
      Send(SessionBegun{});
    } else if (finished_later_) {
      finished_later_ = false;
      open_ = false;
      Send(SessionFinished{});
    }
  }
  void AnswerAll() {
    while (begun_later_ || finished_later_) Answer();
  }
  State state() const { return machine_.state(); }

  int sessions = 0;
  int passages = 0;
  int chained = 0;  // sessions that begin behind a door

 private:
  void Check(const BeginSession& action) {
    EXPECT_FALSE(open_) << "a session begins while another is open";
    EXPECT_FALSE(begun_later_);
    EXPECT_EQ(machine_.state(), State::kStartMapping);
    if (action.after_passage) {
      EXPECT_TRUE(action.map.empty());
      ++chained;
    }
    begun_later_ = true;
  }
  void Check(const FinishSession&) {
    EXPECT_FALSE(finished_later_) << "a session is finished twice";
    EXPECT_TRUE(open_ || begun_later_) << "no session is open";
    begun_later_ = false;
    finished_later_ = true;
  }
  void Check(const WriteReport& action) {
    EXPECT_TRUE(open_) << "a report without a session";
    EXPECT_FALSE(finished_later_) << "a report after the session's end";
    EXPECT_GE(action.report.time, action.report.door_time);
    passages += action.report.kind == sensor::DoorReport::Kind::kPassage ? 1 : 0;
  }
  void Check(const KeepEvidence&) {}
  void Check(const ShowMenu&) { EXPECT_EQ(machine_.state(), State::kMainMenu); }
  void Check(const ShowStatus&) {}
  void Check(const ShowMessage& action) { EXPECT_FALSE(action.text.empty()); }
  void Check(const RemoveMap&) { EXPECT_EQ(machine_.state(), State::kMainMenu); }
  void Check(const RemoveLinkPoint&) { EXPECT_EQ(machine_.state(), State::kMainMenu); }

  StateMachine machine_;
  std::deque<Event> queue_;
  bool open_ = false;
  bool begun_later_ = false;
  bool finished_later_ = false;
};

class RandomDrive {
 public:
  explicit RandomDrive(std::uint64_t seed) : random_(seed) {}

  Event Next() {
    time_ += kNsPerSecond / 5;
    T_odom_robot_.x += 0.1;
    const std::uint64_t roll = random_() % 100;
    if (roll < 50) return Moved{time_, T_odom_robot_};
    if (roll < 75) return Door(roll);
    if (roll < 98) return kCommands[random_() % std::size(kCommands)].command;
    return Command(AskStatus{});
  }

 private:
  Event Door(std::uint64_t roll) {
    doors::DoorEvent event;
    event.kind = roll < 60   ? doors::DoorEvent::Kind::kLatched
                 : roll < 67 ? doors::DoorEvent::Kind::kCandidate
                             : doors::DoorEvent::Kind::kPassage;
    event.door = ++doors_;
    event.time = time_;
    event.door_time = time_ - static_cast<DurationNs>(random_() % 3) * kNsPerSecond;
    event.T_odom_robot = T_odom_robot_;
    event.T_odom_door = T_odom_robot_;
    event.width = 1.0;
    return DoorDetected{event};
  }

  std::mt19937_64 random_;
  TimeNs time_ = 10 * kNsPerSecond;
  Pose2 T_odom_robot_;
  std::int64_t doors_ = 0;
};

TEST(StateMachineProperties, EveryRandomDriveGivesActionsThatCanBeExecuted) {
  int sessions = 0;
  int passages = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    RandomDrive drive(seed);
    std::mt19937_64 random(seed + 1000);
    Harness harness(seed % 2 == 0);
    for (int i = 0; i < 400; ++i) {
      harness.Send(drive.Next());
      if (random() % 3 == 0) harness.Answer();
    }
    harness.AnswerAll();
    EXPECT_NE(harness.state(), State::kEnd) << "nothing ended it";
    harness.Send(seed % 3 == 0 ? Event(Command(Abort{})) : Event(SourceEnded{}));
    harness.AnswerAll();
    EXPECT_EQ(harness.state(), State::kEnd);
    EXPECT_LE(harness.chained, harness.passages) << "each session behind a door follows a reported passage";
    sessions += harness.sessions;
    passages += harness.passages;
    if (::testing::Test::HasFailure()) return;
  }
  EXPECT_GT(sessions, 1000) << "the drives are worth the name";
  EXPECT_GT(passages, 500);
}

}  // namespace
}  // namespace enfilade::robot
