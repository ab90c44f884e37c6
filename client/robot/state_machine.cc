// SPDX-License-Identifier: Apache-2.0
#include "client/robot/state_machine.h"

#include "fmt/format.h"

namespace enfilade::robot {
namespace {

// Doors set by hand have no number of the detector's.
constexpr std::int64_t kByHand = 0;

sensor::DoorReport ReportOf(const doors::DoorEvent& event, sensor::DoorReport::Kind kind, TimeNs time) {
  sensor::DoorReport report;
  report.time = time;
  report.kind = kind;
  report.door_time = event.door_time;
  report.T_odom_door = event.T_odom_door;
  report.width = event.width;
  report.reason = event.reason;
  return report;
}

}  // namespace

const char* NameOf(State state) {
  switch (state) {
    case State::kInitialize:
      return "Initialize";
    case State::kStartMapping:
      return "StartMapping";
    case State::kMapping:
      return "Mapping";
    case State::kStopMapping:
      return "StopMapping";
    case State::kMainMenu:
      return "MainMenu";
    case State::kAbort:
      return "Abort";
    case State::kEnd:
      return "End";
  }
  return "?";
}

std::vector<Action> StateMachine::Handle(const Event& event) {
  actions_.clear();
  std::visit([this](const auto& one) { On(one); }, event);
  return std::move(actions_);
}

void StateMachine::On(const Ready&) {
  if (state_ != State::kInitialize) return;
  if (!options_.automatic) return Leave(State::kMainMenu);
  if (const auto* fresh = std::get_if<RecordNewMap>(&options_.start)) return Begin({fresh->map, std::nullopt, false});
  const auto& old = std::get<MapOnExistingMap>(options_.start);
  Begin({old.map, old.T_map_robot, false});
}

void StateMachine::On(const SessionBegun&) {
  if (state_ != State::kStartMapping) return;
  state_ = State::kMapping;
  const std::vector<doors::DoorEvent> held = std::move(held_);
  held_.clear();
  for (const doors::DoorEvent& event : held) On(DoorSeen{event});
}

void StateMachine::On(const SessionFinished&) {
  if (state_ == State::kAbort) {
    state_ = State::kEnd;
  } else if (state_ == State::kStopMapping && next_) {
    Begin(*std::exchange(next_, std::nullopt));
  } else if (state_ == State::kStopMapping) {
    Leave(left_for_);
  }
}

void StateMachine::On(const DoorSeen& seen) {
  const doors::DoorEvent& event = seen.event;
  if (state_ != State::kMapping && state_ != State::kStopMapping && state_ != State::kStartMapping) return;
  if (event.kind == doors::DoorEvent::Kind::kLatched) {
    Act(KeepEvidence{event.door, event.door_time});
    return Act(Tell{fmt::format("a door of {:.2f} m lies ahead", event.width)});
  }
  // Behind a passage that is not reported yet, or between two sessions: it belongs to the next one.
  if (state_ != State::kMapping || (passage_ && event.door_time > passage_->door_time)) {
    held_.push_back(event);
    if (passage_ && event.kind == doors::DoorEvent::Kind::kPassage) ReportPassage();
    return;
  }
  if (event.kind == doors::DoorEvent::Kind::kPassage) {
    TakePassage(event);
  } else {
    ReportCandidate(event);
  }
}

void StateMachine::TakePassage(const doors::DoorEvent& event) {
  passage_ = event;
  Act(Tell{fmt::format("through a door of {:.2f} m: {}", event.width, event.reason)});
  On(Moved{event.time, event.T_odom_robot});
}

void StateMachine::On(const Moved& moved) {
  now_ = moved.time;
  T_odom_robot_ = moved.T_odom_robot;
  located_ = true;
  if (!passage_ || state_ != State::kMapping) return;
  const double behind = (passage_->T_odom_door.translation() - T_odom_robot_.translation()).norm();
  const double since = ToSeconds(now_ - passage_->time);
  if (behind >= options_.report_behind || since >= options_.report_after) ReportPassage();
}

void StateMachine::On(const SourceEnded&) {
  if (state_ == State::kEnd || state_ == State::kAbort) return;
  held_.clear();
  if (state_ == State::kMapping && passage_) {
    ReportPassage();
    next_.reset();
    left_for_ = State::kEnd;
    return;
  }
  if (state_ == State::kStopMapping) {
    next_.reset();
    left_for_ = State::kEnd;
    return;
  }
  Leave(State::kEnd);
}

void StateMachine::On(const Failed& failed) {
  Act(Tell{"cannot go on: " + failed.reason});
  Leave(State::kAbort);
}

void StateMachine::On(const Command& command) {
  std::visit([this](const auto& one) { Do(one); }, command);
}

void StateMachine::Do(const RecordNewMap& command) {
  if (Allowed(State::kMainMenu, "record new map")) Begin({command.map, std::nullopt, false});
}

void StateMachine::Do(const MapOnExistingMap& command) {
  if (Allowed(State::kMainMenu, "map on old map")) Begin({command.map, command.T_map_robot, false});
}

void StateMachine::Do(const DeleteMap& command) {
  if (!Allowed(State::kMainMenu, "delete map")) return;
  Act(RemoveMap{command.map});
  Act(ShowMenu{});
}

void StateMachine::Do(const DeleteLinkPoint& command) {
  if (!Allowed(State::kMainMenu, "delete link point")) return;
  Act(RemoveLinkPoint{command.link_point});
  Act(ShowMenu{});
}

void StateMachine::Do(const SetLinkPoint& command) {
  if (!Allowed(State::kMapping, "set link point") || !Located("set link point")) return;
  if (!evidence_saved_) Act(KeepEvidence{kByHand, now_});
  sensor::DoorReport report;
  report.time = report.door_time = now_;
  report.kind = sensor::DoorReport::Kind::kPassage;
  report.place = command.place;
  report.T_odom_door = T_odom_robot_;
  report.entered_level = command.level;
  report.by_hand = true;
  report.reason = "set by hand";
  passage_.reset();  // a person's word goes before the detector's
  evidence_saved_ = false;
  Act(WriteReport{kByHand, std::move(report)});
  next_ = BeginSession{"", std::nullopt, true};
  Stop();
}

void StateMachine::Do(const SaveRearImage&) {
  if (!Allowed(State::kMapping, "save rear image") || !Located("save rear image")) return;
  evidence_saved_ = true;
  Act(KeepEvidence{kByHand, now_});
  Act(Tell{"what the robot sees is kept for the link point or candidate that is set next"});
}

void StateMachine::Do(const SetCandidate& command) {
  if (!Allowed(State::kMapping, "set candidate") || !Located("set candidate")) return;
  if (!evidence_saved_) Act(KeepEvidence{kByHand, now_});
  sensor::DoorReport report;
  report.time = report.door_time = now_;
  report.place = command.place;
  report.T_odom_door = T_odom_robot_;
  report.by_hand = true;
  report.reason = "set by hand";
  evidence_saved_ = false;
  Act(WriteReport{kByHand, std::move(report)});
}

void StateMachine::Do(const StopMapping&) {
  if (Allowed(State::kMapping, "stop")) Leave(State::kMainMenu);
}

void StateMachine::Do(const Abort&) { Leave(State::kAbort); }

void StateMachine::Do(const AskStatus&) { Act(ShowStatus{}); }

void StateMachine::Begin(BeginSession session) {
  state_ = State::kStartMapping;
  evidence_saved_ = false;
  Act(std::move(session));
}

void StateMachine::Stop() {
  state_ = State::kStopMapping;
  Act(FinishSession{});
}

void StateMachine::Leave(State state) {
  const bool open = state_ == State::kMapping || state_ == State::kStartMapping;
  if (state != State::kMainMenu || open) {
    passage_.reset();
    next_.reset();
    held_.clear();
  }
  if (state_ == State::kEnd) return;
  if (state == State::kAbort) {
    const bool waits = state_ == State::kStopMapping || state_ == State::kAbort;  // for SessionFinished
    state_ = open || waits ? State::kAbort : State::kEnd;
    if (open) Act(FinishSession{});
    return;
  }
  if (open) {
    left_for_ = state;
    return Stop();
  }
  state_ = state;
  if (state == State::kMainMenu) Act(ShowMenu{});
}

bool StateMachine::Allowed(State state, std::string_view command) {
  if (state_ == state) return true;
  Act(Tell{fmt::format("{}: not now: the robot is in {}, and this is for {}", command, NameOf(state_), NameOf(state))});
  return false;
}

bool StateMachine::Located(std::string_view command) {
  if (located_) return true;
  Act(Tell{fmt::format("{}: there is no scan with odometry yet, so the place is not known", command)});
  return false;
}

void StateMachine::ReportPassage() {
  const doors::DoorEvent event = *std::exchange(passage_, std::nullopt);
  Act(WriteReport{event.door, ReportOf(event, sensor::DoorReport::Kind::kPassage, now_)});
  next_ = BeginSession{"", std::nullopt, true};
  Stop();
}

void StateMachine::ReportCandidate(const doors::DoorEvent& event) {
  Act(Tell{fmt::format("a candidate for a link point: {}", event.reason)});
  Act(WriteReport{event.door, ReportOf(event, sensor::DoorReport::Kind::kCandidate, event.time)});
}

}  // namespace enfilade::robot
