// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
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
#include "client/robot/environment_choice.h"
#include "client/robot/evidence.h"
#include "client/robot/news.h"
#include "client/robot/own_pose.h"
#include "client/robot/robot_options.h"
#include "client/robot/state_machine.h"
#include "client/robot/uploader.h"
#include "client/sdk/connection.h"
#include "client/sdk/spool/spool.h"
#include "core/doors/door_detector.h"
#include "core/sensor/scan_pairing.h"

namespace enfilade::robot {

struct AgentSetup {
  SiteId site;
  RobotId robot;
  std::string source;  // what is recorded, for people
  RobotOptions options;
  std::variant<RecordNewMap, MapOnExistingMap> start;  // of automatic mapping
};

struct AgentCounts {
  std::int64_t records = 0;   // in the spool
  std::int64_t evidence = 0;  // images and clouds among them
  std::int64_t refused = 0;   // while the spool was full
  std::int64_t invalid = 0;   // that no server would take
  std::int64_t ignored = 0;   // while nothing was mapped
  int sessions = 0;
  int candidates = 0;
  int passages = 0;
};

// A robot that maps a campus: what its sensors deliver goes in, and comes out in the spool as sessions, one for each
// map entered, with door reports and their evidence. Between the sensors and the disk there is no server.
//
// What earlier runs left in the spool is brought to the server first; a session that such a run left open is finished
// as it is, since nobody knows where the robot has been meanwhile.
//
// Not thread-safe, but for the uploader.
class Agent {
 public:
  // `spool`, `uploader` and `connection` must outlive the agent. `interrupted`: asked while the spool is full.
  static absl::StatusOr<std::unique_ptr<Agent>> Make(AgentSetup setup, const client::Connection& connection,
                                                     client::Spool& spool, Uploader& uploader, NewsListener listener,
                                                     std::function<bool()> interrupted);

  // Leaves kInitialize.
  absl::Status Start();
  // One thing that a sensor delivered. What is wrong with it is told and counted, not returned. CANCELLED: interrupted;
  // else what the spool says.
  absl::Status Add(const client::SpoolItem& item);
  absl::Status Do(const Command& command) { return Handle(command); }
  // To the server at once, where it can be reached; not kept.
  void ReportPose(const OwnPose& pose);
  // The source has come to its end.
  absl::Status Finish();
  // Puts what was gathered onto the disk; call it from time to time while nothing comes in.
  absl::Status Flush();

  State state() const { return machine_.state(); }
  const AgentCounts& counts() const { return counts_; }

 private:
  Agent(AgentSetup setup, const client::Connection& connection, client::Spool& spool, Uploader& uploader,
        NewsListener listener, std::function<bool()> interrupted, EnvironmentChoice choice);

  absl::Status Handle(const Event& event);
  absl::Status AddScan(const client::SpoolItem& item);
  absl::Status AddOdometry(const client::SpoolItem& item);
  absl::Status AddSettled(std::vector<sensor::PairedScan>& settled);
  absl::Status AddPicture(const client::SpoolItem& item);

  // One for each action.
  absl::Status Act(const BeginSession& action);
  absl::Status Act(const FinishSession&);
  absl::Status Act(const KeepEvidence& action);
  absl::Status Act(const WriteReport& action);
  absl::Status Act(const ShowMenu&);
  absl::Status Act(const ShowStatus&);
  absl::Status Act(const Tell& action);
  absl::Status Act(const RemoveMap& action);
  absl::Status Act(const RemoveLinkPoint& action);

  bool recording() const { return machine_.state() == State::kMapping; }
  absl::Status FinishLeftovers();
  absl::Status BeginWithScan(const client::SpoolItem& item);
  absl::Status Begin(client::SpoolSession session, const std::string& how);
  // For the session's log.
  void Keep(client::SpoolItem item);
  absl::Status Gather(client::SpoolItem item);
  // `essential`: nothing of it is refused where the spool is full.
  absl::Status WriteGathered(bool essential);
  bool NewPicture(const client::SpoolItem& item);  // not yet in the session's log
  void Refuse(const client::SpoolUsage& usage, std::int64_t reserve);
  absl::Status HoldUp(std::int64_t bytes);
  void Say(std::string event, std::string text, nlohmann::json fields = nlohmann::json::object());

  const AgentSetup setup_;
  const client::Connection& connection_;
  client::Spool& spool_;
  Uploader& uploader_;
  const NewsListener listener_;
  const std::function<bool()> interrupted_;

  StateMachine machine_;
  sensor::ScanPairing pairing_;
  doors::DoorDetector detector_;
  EvidenceBuffer evidence_;
  EnvironmentChoice choice_;
  std::map<std::int64_t, std::vector<client::SpoolItem>> kept_;  // by door

  std::optional<BeginSession> to_begin_;  // with the next scan
  std::optional<SessionId> session_;
  int reports_ = 0;                            // in it
  std::set<std::pair<int, TimeNs>> pictures_;  // in it
  std::map<int, TimeNs> next_picture_;         // with all_hz
  std::vector<client::SpoolItem> gathered_;
  std::int64_t gathered_bytes_ = 0;
  std::chrono::steady_clock::time_point last_write_;
  std::optional<sensor::Odometry> odometry_;  // the last
  bool held_up_ = false;                      // told
  AgentCounts counts_;
};

}  // namespace enfilade::robot
