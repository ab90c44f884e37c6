// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "client/robot/agent/lift_exit.h"
#include "core/base/time.h"
#include "core/doors/door_event.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point_kind.h"
#include "core/sensor/record.h"

// Decides what a robot that maps a campus does next: events go in, actions come out, both as values (docs/robot.md).
namespace enfilade::robot {

enum class State {
  kInitialize,    // the sessions of earlier runs are read from the spool
  kStartMapping,  // a session begins
  kMapping,       // the session is recorded and doors are detected
  kStopMapping,   // the session is being finished
  kMainMenu,      // waits for a command
  kAbort,         // the open session is being finished before the end
  kEnd,
};
const char* NameOf(State state);

// Events.

// The spool is open.
struct Ready {};
// The session that BeginSession asked for is in the spool.
struct SessionBegun {};
// The recorded session is finished in the spool.
struct SessionFinished {};
// The door detector has decided on a door.
struct DoorDetected {
  doors::DoorEvent event;
};
// Where the robot is; sent after each scan with odometry.
struct Moved {
  TimeNs time = 0;
  Pose2 T_odom_robot;
};
// What the sensors show does not continue what they showed before (Continuity).
struct Interrupted {
  std::string reason;
};
// The source has no more input.
struct SourceEnded {};
// An error that ends the run.
struct Failed {
  std::string reason;
};

// Commands from a person or a program.
struct RecordNewMap {
  std::string map;  // its name; empty: one is chosen
};
struct MapOnExistingMap {
  std::string map;  // by name or id
  PoseWithCovariance T_map_robot;
};
// Where the robot is has to be found out by its scans.
struct LocateRobot {};
struct DeleteMap {
  std::string map;
};
struct DeleteLinkPoint {
  std::string link_point;
};
// The robot has left the map here, at a door or just behind it.
struct SetLinkPoint {
  graph::LinkPointKind place = graph::LinkPointKind::kDoor;
  std::optional<std::int32_t> level;  // of the map entered
};
// Before a door: what the robot sees now is evidence for the link point or candidate that is set next.
struct SaveRearImage {};
// There is a door ahead that the robot will not drive through now.
struct SetCandidate {
  graph::LinkPointKind place = graph::LinkPointKind::kDoor;
};
// The robot has come to another level, by what a lift or a barometer tells it. Later passages lead to this level. A
// passage that is not reported yet, which led into the lift, is reported at once. So is the passage out of it that the
// detector misses, once the robot has left the lift (lift_exit.h).
struct EnterLevel {
  std::int32_t level = 0;
};
struct StopMapping {};
struct Abort {};
struct AskStatus {};

using Command = std::variant<RecordNewMap, MapOnExistingMap, DeleteMap, DeleteLinkPoint, SetLinkPoint, SaveRearImage,
                             SetCandidate, EnterLevel, StopMapping, Abort, AskStatus>;
using Event =
    std::variant<Ready, SessionBegun, SessionFinished, DoorDetected, Moved, Interrupted, SourceEnded, Failed, Command>;

// Actions, to be executed in order.

// A session into a new or an existing map. After a passage: into the map that the verdict on the passage names.
struct BeginSession {
  std::string map;                                // empty with after_passage
  std::optional<PoseWithCovariance> T_map_robot;  // in an existing map
  bool after_passage = false;                     // entry.previous is the previous session
  bool locate = false;                            // the map is an existing one, if the robot is located there
  bool when_settled = false;                      // only when its scans agree with each other
};
struct FinishSession {};
// Keeps the images and the cloud nearest to `time` for the coming report on `door`. Doors set by hand have number 0.
struct KeepEvidence {
  std::int64_t door = 0;
  TimeNs time = 0;
};
// Writes what was kept for `door` into the session's log, for a passage also images and a cloud from behind the door,
// then the report, completed with the environment entered.
struct WriteReport {
  std::int64_t door = 0;
  sensor::DoorReport report;
};
struct ShowMenu {};
struct ShowStatus {};
struct ShowMessage {
  std::string text;
};
// Deletes it on the server.
struct RemoveMap {
  std::string map;
};
struct RemoveLinkPoint {
  std::string link_point;
};

using Action = std::variant<BeginSession, FinishSession, KeepEvidence, WriteReport, ShowMenu, ShowStatus, ShowMessage,
                            RemoveMap, RemoveLinkPoint>;

struct StateMachineOptions {
  // Doors come from the detector and mapping starts without a command; false: a person gives all commands.
  bool automatic = true;
  // What automatic mapping begins with.
  std::variant<RecordNewMap, MapOnExistingMap, LocateRobot> start;
  // A passage is reported at this distance behind the door, m, or after this time, s, so that its evidence shows the
  // map entered. Or once the robot has stood behind the door for this time, s, as in the cabin of a lift.
  double report_behind = 2.0;
  double report_after = 8.0;
  double report_standing = 2.0;
};

// The robot's states and the transitions between them. Pure: the same events give the same actions.
class StateMachine {
 public:
  explicit StateMachine(StateMachineOptions options) : options_(std::move(options)) {}

  std::vector<Action> Handle(const Event& event);
  State state() const { return state_; }

 private:
  void On(const Ready&);
  void On(const SessionBegun&);
  void On(const SessionFinished&);
  void On(const DoorDetected& seen);
  void On(const Moved& moved);
  void On(const Interrupted& interrupted);
  void On(const SourceEnded&);
  void On(const Failed& failed);
  void On(const Command& command);

  void Do(const RecordNewMap& command);
  void Do(const MapOnExistingMap& command);
  void Do(const DeleteMap& command);
  void Do(const DeleteLinkPoint& command);
  void Do(const SetLinkPoint& command);
  void Do(const SaveRearImage&);
  void Do(const SetCandidate& command);
  void Do(const EnterLevel& command);
  void Do(const StopMapping&);
  void Do(const Abort&);
  void Do(const AskStatus&);

  void Begin(BeginSession session);
  void Stop();
  // To kMainMenu, kAbort or kEnd. An open session is finished first.
  void Leave(State state);

  // False, after a message that says why, if `command` is not possible now.
  bool RequireState(State state, std::string_view command);
  bool RequirePose(std::string_view command);
  void OnPassage(const doors::DoorEvent& event);
  void ReportPassage();
  void ReportCandidate(const doors::DoorEvent& event);
  void Emit(Action action) { actions_.push_back(std::move(action)); }

  StateMachineOptions options_;
  State state_ = State::kInitialize;
  std::vector<Action> actions_;              // in response to the current event
  std::optional<doors::DoorEvent> passage_;  // to be reported once the robot is farther behind the door
  std::optional<doors::DoorEvent> passed_;   // the last passage that was reported
  LiftExit lift_exit_;
  std::optional<std::int32_t> level_;          // the robot's; unset: never told
  std::optional<std::int32_t> level_before_;   // that it came from,
  std::optional<TimeNs> level_time_;           // and when
  std::optional<std::int32_t> passage_level_;  // the robot's when it went through passage_,
  std::optional<TimeNs> passage_level_time_;   // and when it came there, if passage_ is the way out of a lift
  std::vector<doors::DoorEvent> deferred_;     // detected behind that door: they belong to the next session
  std::optional<BeginSession> next_;           // after kStopMapping
  State left_for_ = State::kMainMenu;          // after kStopMapping without next_
  bool evidence_saved_ = false;                // by SaveRearImage
  TimeNs now_ = 0;
  Pose2 T_odom_robot_;
  Eigen::Vector2d stood_at_ = Eigen::Vector2d::Zero();  // the robot has not moved from here
  TimeNs stood_since_ = 0;                              // since then
  bool has_pose_ = false;                               // a Moved was received
};

}  // namespace enfilade::robot
