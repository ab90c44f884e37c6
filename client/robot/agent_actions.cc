// SPDX-License-Identifier: Apache-2.0
// What the agent does when the state machine says so.
#include <chrono>
#include <ctime>

#include "client/robot/agent.h"
#include "client/robot/campus_edits.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"

namespace enfilade::robot {
namespace {

using client::SpoolItem;

constexpr std::size_t kMaxKeptDoors = 16;

std::string MadeUpName(const RobotId& robot) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%d %H:%M:%S", &utc);
  return robot.value() + " " + text;
}

nlohmann::json ToJson(const Pose2& pose) { return {{"x_m", pose.x}, {"y_m", pose.y}, {"yaw_rad", pose.yaw}}; }

}  // namespace

absl::Status Agent::Act(const BeginSession& action) {
  if (action.after_passage) {
    client::SpoolSession session;
    session.entry.previous = session_;
    return Begin(std::move(session), "behind the door; the server will say into which map");
  }
  // Elsewhere than before, perhaps. The session begins with the first scan, which tells where the robot is.
  detector_ = doors::DoorDetector(setup_.options.doors);
  pairing_ = sensor::ScanPairing(sensor::ScanPairingOptions{});
  kept_.clear();
  session_.reset();
  to_begin_ = action;
  return absl::OkStatus();
}

absl::Status Agent::BeginWithScan(const SpoolItem& item) {
  choice_.Add(std::get<sensor::LaserScan>(item.payload));
  const BeginSession action = *std::exchange(to_begin_, std::nullopt);
  std::vector<sensor::PairedScan> none;
  if (odometry_) pairing_.Add(*odometry_, none);
  client::SpoolSession session;
  session.map = action.map.empty() ? MadeUpName(setup_.robot) : action.map;
  session.entry.T_map_robot = action.T_map_robot;
  std::string how = fmt::format("into \"{}\"", session.map);
  if (!action.T_map_robot) {
    const EnvironmentChoice::Verdict verdict = choice_.Choose(0);
    session.environment = verdict.environment;
    how += ", " + verdict.reason;
  }
  return Begin(std::move(session), how);
}

absl::Status Agent::Begin(client::SpoolSession session, const std::string& how) {
  session.site = setup_.site;
  session.robot = setup_.robot;
  session.id = SessionId(NewUuid());
  session.request_id = NewUuid();
  session.source = setup_.source;
  ENFILADE_RETURN_IF_ERROR(spool_.CreateSession(session));
  session_ = session.id;
  reports_ = 0;
  pictures_.clear();
  next_picture_.clear();
  ++counts_.sessions;
  Say("session", fmt::format("session {}: {}", session.id.value(), how),
      {{"session", session.id.value()},
       {"map", session.map},
       {"previous", session.entry.previous ? nlohmann::json(session.entry.previous->value()) : nlohmann::json()}});
  // So that the first scan has odometry on both sides.
  if (odometry_) ENFILADE_RETURN_IF_ERROR(Gather({*odometry_, {}}));
  return Handle(SessionBegun{});
}

absl::Status Agent::Act(const FinishSession&) {
  to_begin_.reset();
  ENFILADE_RETURN_IF_ERROR(WriteGathered(false));
  if (session_) ENFILADE_RETURN_IF_ERROR(spool_.MarkFinished(*session_));
  return Handle(SessionFinished{});
}

absl::Status Agent::Act(const KeepEvidence& action) {
  if (!setup_.options.record_imgs_and_pc) return absl::OkStatus();
  kept_[action.door] = evidence_.At(action.time);
  // The detector numbers doors upwards: the oldest of many is one that it has forgotten.
  while (kept_.size() > kMaxKeptDoors) kept_.erase(kept_.begin());
  return absl::OkStatus();
}

absl::Status Agent::Act(const WriteReport& action) {
  sensor::DoorReport report = action.report;
  const bool passage = report.kind == sensor::DoorReport::Kind::kPassage;
  std::vector<SpoolItem> seen;
  if (const auto kept = kept_.find(action.door); kept != kept_.end()) {
    seen = std::move(kept->second);
    kept_.erase(kept);
  }
  if (setup_.options.record_imgs_and_pc && passage) seen = Joined(std::move(seen), evidence_.Behind(report));
  ENFILADE_RETURN_IF_ERROR(WriteGathered(false));
  std::int64_t written = 0;
  for (SpoolItem& item : seen) {
    if (!NewPicture(item)) continue;
    ++written;
    Keep(std::move(item));
  }
  std::string reason;
  if (passage) {
    const EnvironmentChoice::Verdict verdict = choice_.Choose(report.door_time);
    report.entered_environment = verdict.environment;
    reason = "; " + verdict.reason;
  }
  gathered_.push_back({report, {}});
  ENFILADE_RETURN_IF_ERROR(WriteGathered(true));
  counts_.evidence += written;
  ++(passage ? counts_.passages : counts_.candidates);
  uploader_.Expect(*session_, ++reports_);
  Say("report",
      fmt::format("{} reported with {} images and clouds{}", passage ? "passage" : "candidate", written, reason),
      {{"session", session_->value()},
       {"kind", passage ? "passage" : "candidate"},
       {"door_time_ns", report.door_time},
       {"time_ns", report.time},
       {"pose_odom_door", ToJson(report.T_odom_door)},
       {"width_m", report.width},
       {"by_hand", report.by_hand},
       {"evidence", written},
       {"surroundings",
        report.entered_environment ? nlohmann::json(ToString(*report.entered_environment)) : nlohmann::json()},
       {"reason", report.reason}});
  return absl::OkStatus();
}

absl::Status Agent::Act(const ShowMenu&) {
  Say("menu",
      "Main menu:\n"
      "  new [NAME]                   record a new map\n"
      "  old MAP X Y YAW              map on an old map: where the robot is in it, m and degrees\n"
      "  delete-map MAP\n"
      "  delete-link-point LINK_POINT\n"
      "  abort");
  return absl::OkStatus();
}

absl::Status Agent::Act(const ShowStatus&) {
  const client::SpoolUsage usage = spool_.usage();
  const Uploader::Progress progress = uploader_.progress();
  Say("status",
      fmt::format("{}; map {}; {} sessions, {} candidates, {} passages; {} records, {} refused; spool {:.1f} of {:.0f} "
                  "MiB, {} records and {} sessions wait for the server{}",
                  NameOf(machine_.state()), progress.map.empty() ? "not known yet" : "\"" + progress.map + "\"",
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

absl::Status Agent::Act(const Tell& action) {
  Say("tell", action.text, {{"text", action.text}});
  return absl::OkStatus();
}

absl::Status Agent::Act(const RemoveMap& action) {
  const absl::Status status = DeleteMapOnServer(connection_, setup_.site, action.map);
  const std::string message = status.ok() ? "deleted" : std::string(status.message());
  Say("deleted", fmt::format("map {}: {}", action.map, message), {{"map", action.map}, {"ok", status.ok()}});
  return absl::OkStatus();
}

absl::Status Agent::Act(const RemoveLinkPoint& action) {
  const absl::Status status = DeleteLinkPointOnServer(connection_, setup_.site, action.link_point);
  const std::string message = status.ok() ? "deleted" : std::string(status.message());
  Say("deleted", fmt::format("link point {}: {}", action.link_point, message),
      {{"link_point", action.link_point}, {"ok", status.ok()}});
  return absl::OkStatus();
}

}  // namespace enfilade::robot
