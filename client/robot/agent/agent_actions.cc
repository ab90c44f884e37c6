// SPDX-License-Identifier: Apache-2.0
// How the agent executes the state machine's actions.
#include <chrono>
#include <ctime>
#include <thread>

#include "client/robot/agent/agent.h"
#include "client/robot/agent/campus_edits.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"

namespace enfilade::robot {
namespace {

using client::SpoolItem;

constexpr std::size_t kMaxKeptDoors = 16;
constexpr auto kMappedPoll = std::chrono::milliseconds(50);

std::string DefaultMapName(const RobotId& robot) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%d %H:%M:%S", &utc);
  return robot.value() + " " + text;
}

}  // namespace

absl::Status Agent::Execute(const BeginSession& action) {
  if (action.after_passage) {
    client::SpoolSession session;
    session.entry.previous = session_;
    return Begin(std::move(session), "behind the door; the server decides into which map");
  }
  // The robot may have been moved. The session begins with the first scan, which shows indoors or outdoors.
  detector_ = doors::DoorDetector(setup_.options.doors);
  pairing_ = sensor::ScanPairing(sensor::ScanPairingOptions{});
  kept_.clear();
  session_.reset();
  to_begin_ = action;
  return absl::OkStatus();
}

absl::Status Agent::BeginWithScan(const SpoolItem& item) {
  classifier_.Add(std::get<sensor::LaserScan>(item.payload));
  const BeginSession action = *std::exchange(to_begin_, std::nullopt);
  std::vector<sensor::PairedScan> unused;  // odometry alone pairs no scan
  if (odometry_) pairing_.Add(*odometry_, unused);
  client::SpoolSession session;
  session.map = action.map.empty() ? DefaultMapName(setup_.robot) : action.map;
  session.entry.T_map_robot = action.T_map_robot;
  std::string description = fmt::format("into \"{}\"", session.map);
  if (!action.T_map_robot) {
    const EnvironmentClassifier::Verdict verdict = classifier_.Classify(0);
    session.environment = verdict.environment;
    description += ", " + verdict.reason;
  }
  if (!action.locate) return Begin(std::move(session), description);
  start_.emplace();
  return Begin(std::move(session), "the robot is being located; " + description + " if it is not");
}

absl::Status Agent::Begin(client::SpoolSession session, const std::string& description) {
  session.site = setup_.site;
  session.robot = setup_.robot;
  session.id = SessionId(NewUuid());
  session.request_id = NewUuid();
  session.source = setup_.source;
  if (start_) context_.uploader.Hold(session.id);
  ENFILADE_RETURN_IF_ERROR(context_.spool.CreateSession(session));
  session_ = session.id;
  reports_ = 0;
  recorded_.clear();
  next_evidence_.clear();
  ++counts_.sessions;
  Notify("session", fmt::format("session {}: {}", session.id.value(), description),
         {{"session", session.id.value()},
          {"map", session.map},
          {"previous", session.entry.previous ? nlohmann::json(session.entry.previous->value()) : nlohmann::json()}});
  // With it, the first scan lies between two odometry records.
  if (odometry_) ENFILADE_RETURN_IF_ERROR(Buffer({*odometry_, {}}));
  return Handle(SessionBegun{});
}

absl::Status Agent::LookAround(const sensor::PairedScan& scan) {
  if (start_answer_.valid()) TakeStartAnswer();
  if (start_->Add(scan) && !start_answer_.valid()) {
    T_odom_asked_ = *scan.T_odom_robot;
    if (EarlierMapped()) {
      start_answer_ = std::async(std::launch::async, context_.locate, start_->scans());
      TakeStartAnswer();
    } else {
      start_->Answer(absl::UnavailableError("what the robot recorded before is not mapped yet"), T_odom_asked_);
    }
  }
  const std::optional<StartDecision> decision = start_->Decide();
  return decision ? EnterStartMap(*decision) : absl::OkStatus();
}

// A search in maps that lack the robot's own latest rooms takes another place that looks alike for the robot's.
bool Agent::EarlierMapped() const {
  while (!context_.uploader.EarlierMapped()) {
    const Uploader::Progress progress = context_.uploader.progress();
    const bool hopeless = !progress.reachable || !progress.blocked.empty() || context_.interrupted();
    if (!setup_.options.spool.wait_when_full || hopeless) return false;
    std::this_thread::sleep_for(kMappedPoll);
  }
  return true;
}

void Agent::TakeStartAnswer() {
  if (!setup_.options.spool.wait_when_full &&
      start_answer_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    return;
  }
  start_->Answer(start_answer_.get(), T_odom_asked_);
}

absl::Status Agent::EnterStartMap(const StartDecision& decision) {
  start_.reset();
  start_answer_ = {};
  const bool located = !decision.map.empty();
  if (located) {
    const sensor::SessionEntry entry{std::nullopt, decision.T_map_robot, decision.T_odom_robot};
    ENFILADE_RETURN_IF_ERROR(context_.spool.SetEntry(*session_, decision.map, entry));
  }
  context_.uploader.Release();
  const Pose2& pose = decision.T_map_robot.pose;
  Notify("located",
         located ? fmt::format("located in map {} at x {:.2f} m, y {:.2f} m: {}", decision.map, pose.x, pose.y,
                               decision.reason)
                 : "not located, so a new map begins: " + decision.reason,
         {{"session", session_->value()},
          {"map", located ? nlohmann::json(decision.map) : nlohmann::json()},
          {"pose_map_robot", located ? PoseToJson(pose.x, pose.y, pose.yaw) : nlohmann::json()},
          {"reason", decision.reason}});
  return absl::OkStatus();
}

absl::Status Agent::Execute(const FinishSession&) {
  to_begin_.reset();
  if (start_answer_.valid()) TakeStartAnswer();
  if (start_) ENFILADE_RETURN_IF_ERROR(EnterStartMap(start_->DecideNow()));
  ENFILADE_RETURN_IF_ERROR(WriteBuffer(false));
  if (session_) ENFILADE_RETURN_IF_ERROR(context_.spool.MarkFinished(*session_));
  return Handle(SessionFinished{});
}

absl::Status Agent::Execute(const KeepEvidence& action) {
  if (!setup_.options.record_imgs_and_pc) return absl::OkStatus();
  kept_[action.door] = evidence_.NearestTo(action.time);
  // The detector numbers doors upwards: the lowest of many is one that it no longer follows.
  while (kept_.size() > kMaxKeptDoors) kept_.erase(kept_.begin());
  return absl::OkStatus();
}

absl::Status Agent::Execute(const WriteReport& action) {
  sensor::DoorReport report = action.report;
  const bool passage = report.kind == sensor::DoorReport::Kind::kPassage;
  std::vector<SpoolItem> seen = TakeEvidence(action.door, report);
  ENFILADE_RETURN_IF_ERROR(WriteBuffer(false));
  std::int64_t written = 0;
  for (SpoolItem& item : seen) {
    if (!MarkRecorded(item)) continue;
    ++written;
    Append(std::move(item));
  }
  std::string environment;
  if (passage) {
    const EnvironmentClassifier::Verdict verdict = classifier_.Classify(report.door_time);
    report.entered_environment = verdict.environment;
    environment = "; " + verdict.reason;
  }
  buffer_.push_back({report, {}});
  ENFILADE_RETURN_IF_ERROR(WriteBuffer(true));
  counts_.evidence += written;
  ++(passage ? counts_.passages : counts_.candidates);
  context_.uploader.ExpectVerdicts(*session_, ++reports_);
  NotifyReport(report, written, environment);
  return absl::OkStatus();
}

std::vector<SpoolItem> Agent::TakeEvidence(std::int64_t door, const sensor::DoorReport& report) {
  std::vector<SpoolItem> seen;
  if (const auto kept = kept_.find(door); kept != kept_.end()) {
    seen = std::move(kept->second);
    kept_.erase(kept);
  }
  const bool passage = report.kind == sensor::DoorReport::Kind::kPassage;
  if (!setup_.options.record_imgs_and_pc || !passage) return seen;
  return MergedByTime(std::move(seen), evidence_.BehindDoor(report));
}

void Agent::NotifyReport(const sensor::DoorReport& report, std::int64_t evidence, const std::string& environment) {
  const char* kind = report.kind == sensor::DoorReport::Kind::kPassage ? "passage" : "candidate";
  const std::optional<Environment>& entered = report.entered_environment;
  Notify("report", fmt::format("{} reported with {} images and clouds{}", kind, evidence, environment),
         {{"session", session_->value()},
          {"kind", kind},
          {"door_time_ns", report.door_time},
          {"time_ns", report.time},
          {"pose_odom_door", PoseToJson(report.T_odom_door.x, report.T_odom_door.y, report.T_odom_door.yaw)},
          {"width_m", report.width},
          {"by_hand", report.by_hand},
          {"evidence", evidence},
          {"surroundings", entered ? nlohmann::json(ToString(*entered)) : nlohmann::json()},
          {"reason", report.reason}});
}

absl::Status Agent::Execute(const ShowMenu&) {
  Notify("menu",
         "Main menu:\n"
         "  new [NAME]                   record a new map\n"
         "  existing MAP X Y YAW         continue an existing map from this pose in it (m, degrees)\n"
         "  delete-map MAP\n"
         "  delete-link-point LINK_POINT\n"
         "  abort");
  return absl::OkStatus();
}

absl::Status Agent::Execute(const ShowStatus&) {
  const client::SpoolUsage usage = context_.spool.usage();
  const Uploader::Progress progress = context_.uploader.progress();
  Notify(
      "status",
      fmt::format("{}; map {}; {} sessions, {} candidates, {} passages; {} records, {} refused; spool {:.1f} of {:.0f} "
                  "MiB, {} records and {} sessions wait for the server{}",
                  NameOf(machine_.state()), progress.map.empty() ? "unknown" : "\"" + progress.map + "\"",
                  counts_.sessions, counts_.candidates, counts_.passages, counts_.records, counts_.refused,
                  static_cast<double>(usage.bytes) / (1 << 20), static_cast<double>(usage.max_bytes) / (1 << 20),
                  usage.records, progress.waiting, progress.blocked.empty() ? "" : "; blocked: " + progress.blocked),
      {{"state", NameOf(machine_.state())},
       {"session", session_ ? nlohmann::json(session_->value()) : nlohmann::json()},
       {"map", progress.map_name},
       {"sessions", counts_.sessions},
       {"candidates", counts_.candidates},
       {"passages", counts_.passages},
       {"records", counts_.records},
       {"evidence", counts_.evidence},
       {"refused", counts_.refused},
       {"invalid", counts_.invalid},
       {"spool", {{"bytes", usage.bytes}, {"max_bytes", usage.max_bytes}, {"records", usage.records}}},
       {"sessions_waiting", progress.waiting},
       {"connected", progress.uplink.connected},
       {"blocked", progress.blocked}});
  return absl::OkStatus();
}

absl::Status Agent::Execute(const ShowMessage& action) {
  Notify("tell", action.text, {{"text", action.text}});
  return absl::OkStatus();
}

absl::Status Agent::Execute(const RemoveMap& action) {
  const absl::Status status = DeleteMapOnServer(context_.connection, setup_.site, action.map);
  const std::string message = status.ok() ? "deleted" : std::string(status.message());
  Notify("deleted", fmt::format("map {}: {}", action.map, message), {{"map", action.map}, {"ok", status.ok()}});
  return absl::OkStatus();
}

absl::Status Agent::Execute(const RemoveLinkPoint& action) {
  const absl::Status status = DeleteLinkPointOnServer(context_.connection, setup_.site, action.link_point);
  const std::string message = status.ok() ? "deleted" : std::string(status.message());
  Notify("deleted", fmt::format("link point {}: {}", action.link_point, message),
         {{"link_point", action.link_point}, {"ok", status.ok()}});
  return absl::OkStatus();
}

}  // namespace enfilade::robot
