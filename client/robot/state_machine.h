// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/time.h"
#include "core/doors/door_event.h"
#include "core/geometry/pose2.h"
#include "core/graph/link_point_kind.h"
#include "core/sensor/record.h"

// What a robot that maps a campus does next, as values: events go in, actions come out (docs/robot.md).
namespace enfilade::robot {

enum class State {
  kInitialize,    // the spool of earlier runs is being looked through
  kStartMapping,  // a session is begun
  kMapping,       // it is recorded; doors are looked for
  kStopMapping,   // it is finished
  kMainMenu,      // waits for a person's choice
  kAbort,         // everything is brought to an end at once
  kEnd,
};
const char* NameOf(State state);

// Events.

// The spool is open.
struct Ready {};
// The session that was asked for is in the spool.
struct SessionBegun {};
// The session that was recorded is finished in the spool.
struct SessionFinished {};
// What a detector settled.
struct DoorSeen {
  doors::DoorEvent event;
};
// Where the robot is now; after each scan with odometry.
struct Moved {
  TimeNs time = 0;
  Pose2 T_odom_robot;
};
// The source has nothing more.
struct SourceEnded {};
// Something that cannot be worked round.
struct Failed {
  std::string reason;
};

// Commands: a person's, or a program's in his place.
struct RecordNewMap {
  std::string map;  // its name; empty: one is made up
};
struct MapOnExistingMap {
  std::string map;  // by name or id
  PoseWithCovariance T_map_robot;
};
struct DeleteMap {
  std::string map;
};
struct DeleteLinkPoint {
  std::string link_point;
};
// The robot has left the map: at or behind a door, where it stands.
struct SetLinkPoint {
  graph::LinkPointKind place = graph::LinkPointKind::kDoor;
  std::optional<std::int32_t> level;  // of the map entered
};
// Before a door: what the robot sees now belongs to the link point or candidate set next.
struct SaveRearImage {};
// A door lies ahead, which the robot will not drive through now.
struct SetCandidate {
  graph::LinkPointKind place = graph::LinkPointKind::kDoor;
};
struct StopMapping {};
struct Abort {};
struct AskStatus {};

using Command = std::variant<RecordNewMap, MapOnExistingMap, DeleteMap, DeleteLinkPoint, SetLinkPoint, SaveRearImage,
                             SetCandidate, StopMapping, Abort, AskStatus>;
using Event = std::variant<Ready, SessionBegun, SessionFinished, DoorSeen, Moved, SourceEnded, Failed, Command>;

// Actions, to be done in order.

// A session into a new map or an old one; from a passage on: into the map that the verdict on it names.
struct BeginSession {
  std::string map;                                // empty with after_passage
  std::optional<PoseWithCovariance> T_map_robot;  // of an old map
  bool after_passage = false;                     // entry.previous is the session before
};
struct FinishSession {};
// Keeps images and cloud nearest to `time` for the report on `door` to come. Doors set by hand have the number 0.
struct KeepEvidence {
  std::int64_t door = 0;
  TimeNs time = 0;
};
// Writes what was kept for `door` into the session's log, for a passage also images and a cloud from behind the door,
// and then the report, of whose entered_environment the writer takes care.
struct WriteReport {
  std::int64_t door = 0;
  sensor::DoorReport report;
};
struct ShowMenu {};
struct ShowStatus {};
struct Tell {
  std::string text;
};
// Asks the server.
struct RemoveMap {
  std::string map;
};
struct RemoveLinkPoint {
  std::string link_point;
};

using Action = std::variant<BeginSession, FinishSession, KeepEvidence, WriteReport, ShowMenu, ShowStatus, Tell,
                            RemoveMap, RemoveLinkPoint>;

struct StateMachineOptions {
  // Doors are found by the detector and the robot goes on by itself; false: a person says all.
  bool automatic = true;
  // What automatic mapping begins with.
  std::variant<RecordNewMap, MapOnExistingMap> start;
  // A passage is reported this far behind the door, m, or after so many seconds, so that its evidence shows the map
  // that was entered.
  double report_behind = 2.0;
  double report_after = 8.0;
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
  void On(const DoorSeen& seen);
  void On(const Moved& moved);
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
  void Do(const StopMapping&);
  void Do(const Abort&);
  void Do(const AskStatus&);

  // To another state.
  void Begin(BeginSession session);
  void Stop();
  void Leave(State state);  // kMainMenu, kAbort or kEnd, by way of kStopMapping where a session is open

  // True where `command` may be given now; otherwise tells why not.
  bool Allowed(State state, std::string_view command);
  bool Located(std::string_view command);
  void TakePassage(const doors::DoorEvent& event);
  void ReportPassage();
  void ReportCandidate(const doors::DoorEvent& event);
  void Act(Action action) { actions_.push_back(std::move(action)); }

  StateMachineOptions options_;
  State state_ = State::kInitialize;
  std::vector<Action> actions_;              // of the event that is being handled
  std::optional<doors::DoorEvent> passage_;  // its report waits until the robot is farther behind the door
  std::vector<doors::DoorEvent> held_;       // found behind that door: the next session's
  std::optional<BeginSession> next_;         // after kStopMapping
  State left_for_ = State::kMainMenu;        // after kStopMapping, where there is no next_
  bool evidence_saved_ = false;              // by hand
  TimeNs now_ = 0;
  Pose2 T_odom_robot_;
  bool located_ = false;  // Moved has come
};

}  // namespace enfilade::robot
