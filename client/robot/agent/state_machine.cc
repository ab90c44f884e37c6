// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/state_machine.h"

#include "fmt/format.h"

namespace enfilade::robot {
namespace {

constexpr double kStill = 0.05;        // m: closer together, poses are of a robot that stands
constexpr double kOutOfDoorway = 0.5;  // m

// The detector numbers doors from 1.
constexpr std::int64_t kByHand = 0;

sensor::DoorReport ReportOf(const doors::DoorEvent& event, sensor::DoorReport::Kind kind, TimeNs time) {
  sensor::DoorReport report;
  report.time = time;
  report.kind = kind;
  report.door_time = event.door_time;
  report.T_odom_door = event.T_odom_door;
  report.width = event.width;
  report.T_odom_gap = event.T_odom_gap;
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
  if (std::holds_alternative<LocateRobot>(options_.start)) return Begin({.map = {}, .T_map_robot = {}, .locate = true});
  const auto& existing = std::get<MapOnExistingMap>(options_.start);
  Begin({existing.map, existing.T_map_robot, false});
}

void StateMachine::On(const SessionBegun&) {
  if (state_ != State::kStartMapping) return;
  state_ = State::kMapping;
  const std::vector<doors::DoorEvent> deferred = std::move(deferred_);
  deferred_.clear();
  for (const doors::DoorEvent& event : deferred) On(DoorDetected{event});
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

void StateMachine::On(const DoorDetected& seen) {
  const doors::DoorEvent& event = seen.event;
  if (state_ != State::kMapping && state_ != State::kStopMapping && state_ != State::kStartMapping) return;
  if (event.kind == doors::DoorEvent::Kind::kLatched) {
    Emit(KeepEvidence{event.door, event.door_time});
    return Emit(ShowMessage{fmt::format("door of {:.2f} m ahead", event.width)});
  }
  // Behind a passage that is not reported yet, or between two sessions: it belongs to the next session.
  if (state_ != State::kMapping || (passage_ && event.door_time > passage_->door_time)) {
    deferred_.push_back(event);
    if (passage_ && event.kind == doors::DoorEvent::Kind::kPassage) ReportPassage();
    return;
  }
  if (event.kind == doors::DoorEvent::Kind::kCandidate) return ReportCandidate(event);
  if (const auto out = lift_exit_.FindBefore(event.T_odom_door); out && out->door_time < event.door_time) {
    OnPassage(*out);
    return On(seen);
  }
  OnPassage(event);
}

void StateMachine::OnPassage(const doors::DoorEvent& event) {
  passage_ = event;
  const bool before_ride = level_time_ && event.door_time <= *level_time_;
  if (before_ride) {
    lift_exit_.EnteredBy(event);
  } else if (lift_exit_.is_awaited()) {
    passage_level_time_ = level_time_;
    lift_exit_.Stop();
  }
  passage_level_ = before_ride ? level_before_ : level_;
  Emit(ShowMessage{fmt::format("passed a door of {:.2f} m: {}", event.width, event.reason)});
  if (before_ride) {
    ReportPassage();
  } else {
    On(Moved{event.time, event.T_odom_robot});
  }
}

void StateMachine::On(const Moved& moved) {
  now_ = moved.time;
  T_odom_robot_ = moved.T_odom_robot;
  if (!has_pose_ || (stood_at_ - T_odom_robot_.translation()).norm() > kStill) {
    stood_at_ = T_odom_robot_.translation();
    stood_since_ = now_;
  }
  has_pose_ = true;
  lift_exit_.Add(now_, T_odom_robot_);
  if (state_ != State::kMapping) return;
  if (!passage_) {
    if (const auto out = lift_exit_.FindMissed()) OnPassage(*out);
    return;
  }
  const double behind = (passage_->T_odom_door.translation() - T_odom_robot_.translation()).norm();
  const double since = ToSeconds(now_ - passage_->time);
  const bool waits = behind >= kOutOfDoorway && ToSeconds(now_ - stood_since_) >= options_.report_standing;
  if (behind >= options_.report_behind || since >= options_.report_after || waits) ReportPassage();
}

// The door of a passage that is not reported yet may lie on either side of the break: the survey finds it.
void StateMachine::On(const Interrupted& interrupted) {
  if (state_ != State::kMapping || !options_.automatic) return;
  passage_.reset();
  deferred_.clear();
  Emit(ShowMessage{interrupted.reason + "; the robot is located anew"});
  next_ = BeginSession{.map = {}, .T_map_robot = {}, .locate = true, .when_settled = true};
  Stop();
}

void StateMachine::On(const SourceEnded&) {
  if (state_ == State::kEnd || state_ == State::kAbort) return;
  deferred_.clear();
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
  Emit(ShowMessage{"cannot continue: " + failed.reason});
  Leave(State::kAbort);
}

void StateMachine::On(const Command& command) {
  std::visit([this](const auto& one) { Do(one); }, command);
}

void StateMachine::Do(const RecordNewMap& command) {
  if (RequireState(State::kMainMenu, "record new map")) Begin({command.map, std::nullopt, false});
}

void StateMachine::Do(const MapOnExistingMap& command) {
  if (RequireState(State::kMainMenu, "map on existing map")) Begin({command.map, command.T_map_robot, false});
}

void StateMachine::Do(const DeleteMap& command) {
  if (!RequireState(State::kMainMenu, "delete map")) return;
  Emit(RemoveMap{command.map});
  Emit(ShowMenu{});
}

void StateMachine::Do(const DeleteLinkPoint& command) {
  if (!RequireState(State::kMainMenu, "delete link point")) return;
  Emit(RemoveLinkPoint{command.link_point});
  Emit(ShowMenu{});
}

void StateMachine::Do(const SetLinkPoint& command) {
  if (!RequireState(State::kMapping, "set link point") || !RequirePose("set link point")) return;
  if (!evidence_saved_) Emit(KeepEvidence{kByHand, now_});
  sensor::DoorReport report;
  report.time = report.door_time = now_;
  report.kind = sensor::DoorReport::Kind::kPassage;
  report.place = command.place;
  report.T_odom_door = T_odom_robot_;
  report.entered_level = command.level ? command.level : level_;
  report.by_hand = true;
  report.reason = "set by hand";
  passage_.reset();  // the command overrides the detector
  evidence_saved_ = false;
  Emit(WriteReport{kByHand, std::move(report)});
  next_ = BeginSession{"", std::nullopt, true};
  Stop();
}

void StateMachine::Do(const SaveRearImage&) {
  if (!RequireState(State::kMapping, "save rear image") || !RequirePose("save rear image")) return;
  evidence_saved_ = true;
  Emit(KeepEvidence{kByHand, now_});
  Emit(ShowMessage{"this view is kept for the next link point or candidate"});
}

void StateMachine::Do(const SetCandidate& command) {
  if (!RequireState(State::kMapping, "set candidate") || !RequirePose("set candidate")) return;
  if (!evidence_saved_) Emit(KeepEvidence{kByHand, now_});
  sensor::DoorReport report;
  report.time = report.door_time = now_;
  report.place = command.place;
  report.T_odom_door = T_odom_robot_;
  report.by_hand = true;
  report.reason = "set by hand";
  evidence_saved_ = false;
  Emit(WriteReport{kByHand, std::move(report)});
}

// A cabin may be too short to come `report_behind` its door, and what is seen from now on is of another level.
void StateMachine::Do(const EnterLevel& command) {
  if (level_ == command.level) return;
  if (passage_ && state_ == State::kMapping) ReportPassage();
  level_before_ = std::exchange(level_, command.level);
  if (!has_pose_) return;
  level_time_ = now_;
  if (!options_.automatic) return;
  lift_exit_.Begin(T_odom_robot_);
  if (passed_) lift_exit_.EnteredBy(*passed_);
}

void StateMachine::Do(const StopMapping&) {
  if (RequireState(State::kMapping, "stop")) Leave(State::kMainMenu);
}

void StateMachine::Do(const Abort&) { Leave(State::kAbort); }

void StateMachine::Do(const AskStatus&) { Emit(ShowStatus{}); }

void StateMachine::Begin(BeginSession session) {
  state_ = State::kStartMapping;
  evidence_saved_ = false;
  Emit(std::move(session));
}

void StateMachine::Stop() {
  state_ = State::kStopMapping;
  Emit(FinishSession{});
}

void StateMachine::Leave(State state) {
  const bool open = state_ == State::kMapping || state_ == State::kStartMapping;
  if (state != State::kMainMenu || open) {
    passage_.reset();
    next_.reset();
    deferred_.clear();
  }
  if (state_ == State::kEnd) return;
  if (state == State::kAbort) {
    const bool finishing = state_ == State::kStopMapping || state_ == State::kAbort;
    state_ = open || finishing ? State::kAbort : State::kEnd;
    if (open) Emit(FinishSession{});
    return;
  }
  if (open) {
    left_for_ = state;
    return Stop();
  }
  state_ = state;
  if (state == State::kMainMenu) Emit(ShowMenu{});
}

bool StateMachine::RequireState(State state, std::string_view command) {
  if (state_ == state) return true;
  Emit(ShowMessage{fmt::format("{}: not possible now: the robot is in {}, and this command is for {}", command,
                               NameOf(state_), NameOf(state))});
  return false;
}

bool StateMachine::RequirePose(std::string_view command) {
  if (has_pose_) return true;
  Emit(ShowMessage{fmt::format("{}: there is no scan with odometry yet, so the pose is unknown", command)});
  return false;
}

void StateMachine::ReportPassage() {
  const doors::DoorEvent event = *std::exchange(passage_, std::nullopt);
  passed_ = event;
  sensor::DoorReport report = ReportOf(event, sensor::DoorReport::Kind::kPassage, now_);
  report.entered_level = passage_level_;
  report.level_time = std::exchange(passage_level_time_, std::nullopt);
  Emit(WriteReport{event.door, std::move(report)});
  next_ = BeginSession{"", std::nullopt, true};
  Stop();
}

void StateMachine::ReportCandidate(const doors::DoorEvent& event) {
  Emit(ShowMessage{fmt::format("candidate for a link point: {}", event.reason)});
  Emit(WriteReport{event.door, ReportOf(event, sensor::DoorReport::Kind::kCandidate, event.time)});
}

}  // namespace enfilade::robot
