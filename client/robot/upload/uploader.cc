// SPDX-License-Identifier: Apache-2.0
#include "client/robot/upload/uploader.h"

#include <cmath>
#include <utility>

#include "core/base/error.h"

namespace enfilade::robot {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kUplinkPoll = std::chrono::milliseconds(100);

}  // namespace

Uploader::Uploader(const client::Connection& connection, client::Spool& spool, convert::RobotName robot,
                   NotificationListener listener, const UploaderOptions& options)
    : connection_(connection),
      spool_(spool),
      listener_(listener),
      options_(options),
      follower_(connection, std::move(robot), std::move(listener),
                {.expected_verdicts = [this](const SessionId& session) { return ExpectedVerdicts(session); },
                 .on_map_entered = [this](const SessionId& session,
                                          const v1::MapEntered& entered) { OnMapEntered(session, entered); }}) {}

Uploader::~Uploader() { Stop(); }

void Uploader::Start() {
  worker_ = std::thread([this] { Run(); });
}

void Uploader::Stop() {
  std::shared_ptr<client::Uplink> uplink;
  {
    MutexLock lock(mutex_);
    stopping_ = true;
    uplink = uplink_;
    changed_.NotifyAll();
  }
  if (uplink) uplink->Stop();
  if (worker_.joinable()) worker_.join();
}

void Uploader::Hold(const SessionId& session) {
  MutexLock lock(mutex_);
  held_ = session;
}

void Uploader::Release() {
  MutexLock lock(mutex_);
  held_.reset();
  changed_.NotifyAll();
}

void Uploader::ExpectVerdicts(const SessionId& session, int count) {
  MutexLock lock(mutex_);
  expected_[session.value()] = count;
}

int Uploader::ExpectedVerdicts(const SessionId& session) {
  MutexLock lock(mutex_);
  const auto found = expected_.find(session.value());
  return found == expected_.end() ? 0 : found->second;
}

void Uploader::ReportPose(const std::string& map, const PoseWithCovariance& T_map_robot, TimeNs time) {
  std::shared_ptr<client::Uplink> uplink;
  {
    MutexLock lock(mutex_);
    uplink = uplink_;
  }
  if (uplink) uplink->ReportPose(map, T_map_robot, time);
}

Uploader::Progress Uploader::progress() {
  MutexLock lock(mutex_);
  return progress_;
}

bool Uploader::Done(bool judged) {
  for (const client::SpoolSession& session : spool_.ListSessions()) {
    if (session.finished && !session.closed) return false;
  }
  MutexLock lock(mutex_);
  return !uplink_ && (!judged || progress_.followed == 0);
}

bool Uploader::EarlierMapped() {
  const std::vector<client::SpoolSession> sessions = spool_.ListSessions();
  MutexLock lock(mutex_);
  for (const client::SpoolSession& session : sessions) {
    if (session.id == held_) break;
    if (!session.closed) return false;
  }
  return !uplink_ && progress_.unmapped == 0;
}

void Uploader::Run() {
  Clock::time_point next_follow = Clock::now();
  while (true) {
    std::shared_ptr<client::Uplink> uplink;
    {
      MutexLock lock(mutex_);
      if (stopping_) return;
      uplink = uplink_;
      if (!uplink) changed_.WaitUntil(mutex_, Clock::now() + kUplinkPoll);
    }
    if (!uplink) {
      StartNext();
    } else {
      const std::optional<absl::Status> end = uplink->WaitFor(kUplinkPoll);
      UpdateProgress();
      if (end) OnUplinkEnded(*end);
    }
    if (Clock::now() >= next_follow) {
      Follow();
      next_follow =
          Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options_.follow_s));
    }
  }
}

void Uploader::StartNext() {
  std::int64_t waiting = 0;
  std::optional<SessionId> next;
  for (const client::SpoolSession& session : spool_.ListSessions()) {
    if (session.closed) continue;
    ++waiting;
    if (!next) next = session.id;
  }
  MutexLock lock(mutex_);
  progress_.waiting = waiting;
  const bool blocked = !progress_.blocked.empty() && Clock::now() < retry_blocked_;
  if (!next || next == held_ || stopping_ || blocked) return;
  progress_.blocked.clear();
  client::UplinkOptions options = options_.uplink;
  options.on_map_entered = [this, id = *next](const v1::MapEntered& entered) { OnMapEntered(id, entered); };
  session_ = *next;
  progress_.session = next->value();
  progress_.uplink = {};
  uplink_ = std::make_shared<client::Uplink>(connection_, spool_, *next, options);
  uplink_->Start();
}

void Uploader::UpdateProgress() {
  std::int64_t waiting = 0;
  for (const client::SpoolSession& session : spool_.ListSessions()) waiting += session.closed ? 0 : 1;
  std::string error;
  std::string pose_error;
  {
    MutexLock lock(mutex_);
    if (!uplink_) return;
    progress_.uplink = uplink_->progress();
    progress_.reachable = progress_.uplink.last_error.empty();
    progress_.waiting = waiting;
    error = progress_.uplink.last_error;
    pose_error = progress_.uplink.pose_error;
  }
  if (pose_error != last_pose_error_ && !pose_error.empty()) {
    listener_({"pose_refused", "the server refuses the robot's pose: " + pose_error, {{"error", pose_error}}});
  }
  last_pose_error_ = pose_error;
  if (error == last_error_) return;
  last_error_ = error;
  if (error.empty()) return listener_({"uplink", "the server accepts records again", {{"error", nullptr}}});
  listener_({"uplink", error + "; recording continues, nothing is lost", {{"error", error}}});
}

void Uploader::Follow() {
  follower_.Poll();
  if (options_.global_pose) follower_.PollGlobalPose();
  MutexLock lock(mutex_);
  progress_.followed = follower_.size();
  progress_.unmapped = follower_.unmapped();
  if (!uplink_) progress_.reachable = follower_.reachable();
}

void Uploader::OnUplinkEnded(const absl::Status& status) {
  SessionId session;
  {
    MutexLock lock(mutex_);
    session = session_;
    uplink_.reset();
    progress_.session.clear();
    if (absl::IsCancelled(status)) return;
    if (!status.ok()) {
      progress_.blocked = std::string(status.message());
      retry_blocked_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                          std::chrono::duration<double>(options_.retry_blocked_s));
    }
    if (status.ok()) {
      ++progress_.followed;
      ++progress_.unmapped;
    }
  }
  if (!status.ok()) {
    const std::string message(status.message());
    return listener_({"blocked",
                      fmt::format("session {} cannot be uploaded: {}; it and later sessions stay in {}",
                                  session.value(), message, spool_.path()),
                      {{"session", session.value()}, {"error", message}}});
  }
  follower_.Add(session);
  listener_({"uploaded", fmt::format("session {} is uploaded", session.value()), {{"session", session.value()}}});
  const auto quarantined = spool_.ListQuarantined(session);
  if (quarantined.ok() && quarantined->empty()) spool_.RemoveSession(session).IgnoreError();
}

void Uploader::OnMapEntered(const SessionId& session, const v1::MapEntered& entered) {
  {
    MutexLock lock(mutex_);
    if (progress_.map_name == entered.map()) return;
    progress_.map_name = entered.map();
    progress_.map = entered.map_display_name();
  }
  nlohmann::json fields{
      {"session", session.value()}, {"map", entered.map()}, {"display_name", entered.map_display_name()}};
  std::string where;
  if (entered.has_pose_map_robot()) {
    const v1::Pose2& pose = entered.pose_map_robot().pose();
    fields["pose_map_robot"] = PoseToJson(pose.x(), pose.y(), pose.yaw());
    where = fmt::format(" at x {:.2f} m, y {:.2f} m, yaw {:.1f} deg", pose.x(), pose.y(), pose.yaw() * 180.0 / M_PI);
  }
  listener_({"map", fmt::format("entered the map \"{}\"{}", entered.map_display_name(), where), std::move(fields)});
}

}  // namespace enfilade::robot
