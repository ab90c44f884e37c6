// SPDX-License-Identifier: Apache-2.0
#include "client/robot/uploader.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/sdk/uplink/session_setup.h"
#include "core/base/error.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"

namespace enfilade::robot {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kUplinkPoll = std::chrono::milliseconds(100);

std::string LastSegment(const std::string& name) { return name.substr(name.rfind('/') + 1); }

// "LINK_POINT_MADE" -> "link point made"
std::string InWords(const v1::DoorVerdict& verdict) {
  std::string words = v1::DoorVerdict::Decision_Name(verdict.decision());
  constexpr std::string_view kPrefix = "DECISION_";
  if (words.starts_with(kPrefix)) words.erase(0, kPrefix.size());
  for (char& c : words) c = c == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return words;
}

nlohmann::json ToJson(const v1::Pose2& pose) { return {{"x_m", pose.x()}, {"y_m", pose.y()}, {"yaw_rad", pose.yaw()}}; }

}  // namespace

Uploader::Uploader(const client::Connection& connection, client::Spool& spool, convert::RobotName robot,
                   NewsListener listener, const UploaderOptions& options)
    : connection_(connection),
      spool_(spool),
      robot_(std::move(robot)),
      listener_(std::move(listener)),
      options_(options) {}

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

void Uploader::Expect(const SessionId& session, int reports) {
  MutexLock lock(mutex_);
  expected_[session.value()] = reports;
}

int Uploader::ExpectedOf(const SessionId& session) {
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
      Look();
      if (end) Ended(*end);
    }
    if (Clock::now() >= next_follow) {
      Follow();
      if (options_.global_pose) TellGlobalPose();
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
  if (!next || stopping_ || !progress_.blocked.empty()) return;
  client::UplinkOptions options = options_.uplink;
  options.on_map_entered = [this, id = *next](const v1::MapEntered& entered) { TellMap(id, entered); };
  session_ = *next;
  progress_.session = next->value();
  progress_.uplink = {};
  uplink_ = std::make_shared<client::Uplink>(connection_, spool_, *next, options);
  uplink_->Start();
}

void Uploader::Look() {
  std::int64_t waiting = 0;
  for (const client::SpoolSession& session : spool_.ListSessions()) waiting += session.closed ? 0 : 1;
  std::string error;
  std::string pose_error;
  {
    MutexLock lock(mutex_);
    if (!uplink_) return;
    progress_.uplink = uplink_->progress();
    progress_.waiting = waiting;
    error = progress_.uplink.last_error;
    pose_error = progress_.uplink.pose_error;
  }
  if (pose_error != last_pose_error_ && !pose_error.empty()) {
    listener_({"pose_refused", "the server does not take the robot's pose: " + pose_error, {{"error", pose_error}}});
  }
  last_pose_error_ = pose_error;
  if (error == last_error_) return;
  last_error_ = error;
  if (error.empty()) return listener_({"uplink", "the server takes records again", {{"error", nullptr}}});
  listener_({"uplink", error + "; recording goes on, nothing is lost", {{"error", error}}});
}

void Uploader::Ended(const absl::Status& status) {
  SessionId session;
  {
    MutexLock lock(mutex_);
    session = session_;
    uplink_.reset();
    progress_.session.clear();
    if (absl::IsCancelled(status)) return;
    if (!status.ok()) progress_.blocked = std::string(status.message());
    if (status.ok()) ++progress_.followed;
  }
  if (!status.ok()) {
    const std::string message(status.message());
    return listener_({"blocked",
                      fmt::format("session {} cannot be brought to the server: {}; it and what comes after it stays in "
                                  "{}",
                                  session.value(), message, spool_.path()),
                      {{"session", session.value()}, {"error", message}}});
  }
  followed_.push_back({session});
  listener_(
      {"uploaded", fmt::format("session {} is with the server", session.value()), {{"session", session.value()}}});
  const auto quarantined = spool_.ListQuarantined(session);
  if (quarantined.ok() && quarantined->empty()) spool_.RemoveSession(session).IgnoreError();
}

void Uploader::Follow() {
  std::erase_if(followed_, [&](Followed& followed) { return FollowOne(followed); });
  MutexLock lock(mutex_);
  progress_.followed = static_cast<std::int64_t>(followed_.size());
}

bool Uploader::FollowOne(Followed& followed) {
  const absl::StatusOr<v1::Session> session = client::GetSession(connection_, robot_.site, followed.session);
  if (!session.ok())
    return client::IsPermanent(session.status());  // deleted: nothing will come; else the next look tells
  const bool ended = session->state() == v1::Session::STATE_MAPPED || session->state() == v1::Session::STATE_FAILED;
  const bool failed = session->state() == v1::Session::STATE_FAILED;
  if (!followed.told_map && !session->map().empty()) {
    followed.told_map = true;
    v1::MapEntered entered;
    entered.set_map(session->map());
    entered.set_map_display_name(DisplayNameOf(session->map()));
    if (session->entry().has_pose_map_robot()) *entered.mutable_pose_map_robot() = session->entry().pose_map_robot();
    TellMap(followed.session, entered);
  }
  if (ended && !followed.mapped) {
    followed.mapped = true;
    listener_({"mapped",
               failed ? fmt::format("session {} could not be mapped: {}", followed.session.value(), session->error())
                      : fmt::format("session {} is mapped into \"{}\"", followed.session.value(),
                                    DisplayNameOf(session->map())),
               {{"session", followed.session.value()}, {"map", session->map()}, {"failed", failed}}});
  }
  v1::ListDoorVerdictsRequest request;
  request.set_parent(convert::NameOf(convert::SessionName{robot_.site, followed.session}));
  request.set_page_size(1000);
  const auto verdicts = connection_.Call(&v1::SessionService::Stub::ListDoorVerdicts, request);
  if (!verdicts.ok()) return false;
  for (; followed.verdicts < verdicts->verdicts_size(); ++followed.verdicts) {
    TellVerdict(followed.session, verdicts->verdicts(followed.verdicts));
  }
  // A session that was only recorded is never mapped.
  return (followed.mapped || session->map().empty()) && followed.verdicts >= ExpectedOf(followed.session) &&
         (ended || session->entry().previous_session().empty());
}

void Uploader::TellVerdict(const SessionId& session, const v1::DoorVerdict& verdict) {
  std::string text = InWords(verdict);
  if (!verdict.link_point().empty()) text += fmt::format(" {}", LastSegment(verdict.link_point()));
  if (!verdict.entered_map().empty()) text += fmt::format(", into \"{}\"", DisplayNameOf(verdict.entered_map()));
  if (!verdict.reason().empty()) text += fmt::format(": {}", verdict.reason());
  nlohmann::json comparisons = nlohmann::json::array();
  for (const v1::DoorComparison& one : verdict.comparisons()) {
    comparisons.push_back({{"link_point", one.link_point()},
                           {"map", one.map()},
                           {"distance_m", one.distance_m()},
                           {"image_matches", one.image_matches()},
                           {"registration_rmse_m", one.registration_rmse_m()},
                           {"registration_inlier_share", one.registration_inlier_share()},
                           {"chi2", one.chi2()},
                           {"accepted", one.accepted()},
                           {"reason", one.reason()}});
  }
  listener_({"verdict",
             std::move(text),
             {{"session", session.value()},
              {"decision", v1::DoorVerdict::Decision_Name(verdict.decision())},
              {"link_point", verdict.link_point()},
              {"entered_map", verdict.entered_map()},
              {"graph_version", verdict.graph_version()},
              {"reason", verdict.reason()},
              {"comparisons", std::move(comparisons)}}});
}

void Uploader::TellMap(const SessionId& session, const v1::MapEntered& entered) {
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
    fields["pose_map_robot"] = ToJson(pose);
    where = fmt::format(" at x {:.2f} m, y {:.2f} m, yaw {:.1f} deg", pose.x(), pose.y(), pose.yaw() * 180.0 / M_PI);
  }
  listener_({"map", fmt::format("entered the map \"{}\"{}", entered.map_display_name(), where), std::move(fields)});
}

void Uploader::TellGlobalPose() {
  v1::GetGlobalPoseRequest request;
  request.set_robot(convert::NameOf(robot_));
  const auto response = connection_.Call(&v1::GraphService::Stub::GetGlobalPose, request);
  if (!response.ok() || !response->global_pose().has_pose_world_robot()) return;
  const v1::GlobalPose& pose = response->global_pose();
  if (pose.SerializeAsString() == last_global_pose_) return;
  last_global_pose_ = pose.SerializeAsString();
  const v1::Pose2& T_world_robot = pose.pose_world_robot().pose();
  listener_({"global_pose",
             "",
             {{"map", pose.map_pose().map()},
              {"time_ns", pose.report_time().seconds() * kNsPerSecond + pose.report_time().nanos()},
              {"pose_world_robot", ToJson(T_world_robot)},
              {"covariance", std::vector<double>(pose.pose_world_robot().covariance().begin(),
                                                 pose.pose_world_robot().covariance().end())},
              {"graph_version", pose.graph_version()}}});
}

std::string Uploader::DisplayNameOf(const std::string& map) {
  if (const auto known = map_names_.find(map); known != map_names_.end()) return known->second;
  v1::GetMapRequest request;
  request.set_name(map);
  const auto response = connection_.Call(&v1::MapService::Stub::GetMap, request);
  if (!response.ok()) return LastSegment(map);
  return map_names_[map] = response->map().display_name();
}

}  // namespace enfilade::robot
