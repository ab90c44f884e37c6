// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/robot/agent/continuity.h"
#include "client/robot/agent/environment_classifier.h"
#include "client/robot/agent/evidence_buffer.h"
#include "client/robot/agent/record_clock.h"
#include "client/robot/agent/start_location.h"
#include "client/robot/agent/state_machine.h"
#include "client/robot/input/pose_report.h"
#include "client/robot/notification.h"
#include "client/robot/robot_options.h"
#include "client/robot/upload/uploader.h"
#include "client/sdk/connection.h"
#include "client/sdk/spool/spool.h"
#include "core/doors/door_detector.h"
#include "core/sensor/scan_pairing.h"

namespace enfilade::robot {

struct AgentSetup {
  SiteId site;
  RobotId robot;
  std::string source;  // where the records come from, for people
  RobotOptions options;
  std::variant<RecordNewMap, MapOnExistingMap, LocateRobot> start;  // of automatic mapping
};

// What an agent works with. All references must outlive it.
struct AgentContext {
  const client::Connection& connection;
  client::Spool& spool;
  Uploader& uploader;
  NotificationListener listener;
  std::function<bool()> interrupted;  // asked while the agent waits for space in the spool
  LocateByScans locate = {};          // of a robot that does not know where it starts; called by another thread
};

struct AgentCounts {
  std::int64_t records = 0;   // in the spool
  std::int64_t evidence = 0;  // images and clouds among them
  std::int64_t refused = 0;   // while the spool was full
  std::int64_t invalid = 0;   // that no server would accept
  std::int64_t ignored = 0;   // while no map was recorded
  int sessions = 0;
  int candidates = 0;
  int passages = 0;
};

// A robot that maps a campus. Sensor data goes in; sessions come out in the spool, one for each map entered, with door
// reports and their evidence. Recording needs no server.
//
// What earlier runs left in the spool is uploaded first. A session that such a run left open is finished as it is,
// because nobody knows where the robot has been since.
//
// While a robot that does not know where it is looks for itself (LocateRobot), its session waits in the spool, so that
// it can still go into the map where the robot is found.
//
// Not thread-safe; the uploader is.
class Agent {
 public:
  // FAILED_PRECONDITION: the spool belongs to another robot. INVALID_ARGUMENT: the options are invalid.
  static absl::StatusOr<std::unique_ptr<Agent>> Make(AgentSetup setup, AgentContext context);

  // Leaves State::kInitialize.
  absl::Status Start();
  // One record from a sensor. An invalid one is reported and counted, not returned as an error. CANCELLED: interrupted
  // while waiting for space; otherwise the spool's error.
  absl::Status Add(const client::SpoolItem& item);
  absl::Status Do(const Command& command) { return Handle(command); }
  // Sends the pose to the server at once if it can be reached. Poses are not stored.
  void ReportPose(const PoseReport& report);
  // The source has ended.
  absl::Status Finish();
  // Writes the buffered records to the spool. Call it from time to time while no input comes.
  absl::Status Flush();

  State state() const { return machine_.state(); }
  const AgentCounts& counts() const { return counts_; }

 private:
  Agent(AgentSetup setup, AgentContext context, EnvironmentClassifier classifier);

  absl::Status Handle(const Event& event);
  absl::Status AddValid(const client::SpoolItem& item);
  absl::Status ReleaseHeld();
  absl::Status Take(const client::SpoolItem& item);
  absl::Status AddScan(const client::SpoolItem& item);
  absl::Status AddOdometry(const client::SpoolItem& item);
  absl::Status AddPairedScans(std::vector<sensor::PairedScan>& scans);
  absl::Status AddEvidence(const client::SpoolItem& item);

  // One for each action of the state machine.
  absl::Status Execute(const BeginSession& action);
  absl::Status Execute(const FinishSession&);
  absl::Status Execute(const KeepEvidence& action);
  absl::Status Execute(const WriteReport& action);
  absl::Status Execute(const ShowMenu&);
  absl::Status Execute(const ShowStatus&);
  absl::Status Execute(const ShowMessage& action);
  absl::Status Execute(const RemoveMap& action);
  absl::Status Execute(const RemoveLinkPoint& action);

  bool recording() const { return machine_.state() == State::kMapping; }
  absl::Status FinishLeftovers();
  absl::Status BeginWithScan(const client::SpoolItem& item);
  absl::Status Begin(client::SpoolSession session, const std::string& description);
  // While the robot is not located: asks the server if that is due, and takes its answer.
  absl::Status LookAround(const sensor::PairedScan& scan);
  // Whether the server has mapped what the robot recorded before. Waits for it if the source can wait and the server
  // answers.
  bool EarlierMapped() const;
  // Waits for the answer if the source can wait.
  void TakeStartAnswer();
  absl::Status EnterStartMap(const StartDecision& decision);
  // The evidence for a report: what was kept for its door and, for a passage, what was seen behind it.
  std::vector<client::SpoolItem> TakeEvidence(std::int64_t door, const sensor::DoorReport& report);
  void NotifyReport(const sensor::DoorReport& report, std::int64_t evidence, const std::string& environment);
  // Appends to the buffer.
  void Append(client::SpoolItem item);
  // Appends to the buffer, and writes it to the spool when it is due.
  absl::Status Buffer(client::SpoolItem item);
  // `essential`: nothing of it is refused, even if the spool is full.
  absl::Status WriteBuffer(bool essential);
  // True once for each image or cloud of a session.
  bool MarkRecorded(const client::SpoolItem& item);
  void RefuseWhenFull(const client::SpoolUsage& usage);
  absl::Status WaitForSpace(std::int64_t bytes);
  void Notify(std::string event, std::string text, nlohmann::json fields = nlohmann::json::object());

  const AgentSetup setup_;
  const AgentContext context_;

  StateMachine machine_;
  sensor::ScanPairing pairing_;
  doors::DoorDetector detector_;
  Continuity continuity_;
  std::vector<client::SpoolItem> held_;  // since the first of the last scans that do not continue those before
  RecordClock clock_;
  EvidenceBuffer evidence_;
  EnvironmentClassifier classifier_;
  std::map<std::int64_t, std::vector<client::SpoolItem>> kept_;  // by door

  std::optional<BeginSession> to_begin_;  // with the next scan
  std::optional<StartLocation> start_;    // until it is decided into which map session_ goes
  std::future<absl::StatusOr<StartAnswer>> start_answer_;
  Pose2 T_odom_asked_;
  std::optional<SessionId> session_;
  int reports_ = 0;                            // in the session
  std::set<std::pair<int, TimeNs>> recorded_;  // images and clouds in the session, by series and time
  std::map<int, TimeNs> next_evidence_;        // by series, with all_hz
  std::vector<client::SpoolItem> buffer_;      // not yet in the spool
  std::int64_t buffered_bytes_ = 0;
  std::chrono::steady_clock::time_point last_write_;
  std::optional<sensor::Odometry> odometry_;  // the latest
  bool spool_full_ = false;                   // reported
  AgentCounts counts_;
};

}  // namespace enfilade::robot
