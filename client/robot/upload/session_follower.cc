// SPDX-License-Identifier: Apache-2.0
#include "client/robot/upload/session_follower.h"

#include <algorithm>
#include <cctype>
#include <utility>
#include <vector>

#include "client/sdk/uplink/session_setup.h"
#include "core/base/time.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/server_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"

namespace enfilade::robot {
namespace {

std::string LastSegment(const std::string& name) { return name.substr(name.rfind('/') + 1); }

// "LINK_POINT_MADE" -> "link point made"
std::string DecisionText(const v1::DoorVerdict& verdict) {
  std::string text = v1::DoorVerdict::Decision_Name(verdict.decision());
  constexpr std::string_view kPrefix = "DECISION_";
  if (text.starts_with(kPrefix)) text.erase(0, kPrefix.size());
  for (char& c : text) c = c == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool HasFailed(const v1::Session& session) { return session.state() == v1::Session::STATE_FAILED; }
bool HasEnded(const v1::Session& session) { return session.state() == v1::Session::STATE_MAPPED || HasFailed(session); }

}  // namespace

SessionFollower::SessionFollower(const client::Connection& connection, convert::RobotName robot,
                                 NotificationListener listener, Hooks hooks)
    : connection_(connection), robot_(std::move(robot)), listener_(std::move(listener)), hooks_(std::move(hooks)) {}

void SessionFollower::Poll() {
  bool not_surveyed = false;  // those that await a survey
  std::erase_if(sessions_, [&](Followed& followed) {
    if (followed.awaits_survey && not_surveyed) return false;
    const bool done = PollSession(followed);
    not_surveyed = not_surveyed || (followed.awaits_survey && !done);
    return done;
  });
}

std::int64_t SessionFollower::unmapped() const {
  return std::count_if(sessions_.begin(), sessions_.end(), [](const Followed& followed) { return !followed.mapped; });
}

bool SessionFollower::PollSession(Followed& followed) {
  const absl::StatusOr<v1::Session> session = client::GetSession(connection_, robot_.site, followed.session);
  reachable_ = session.ok() || client::IsPermanent(session.status());
  // Permanent: it was deleted, and nothing more will come. Otherwise the next poll asks again.
  if (!session.ok()) return client::IsPermanent(session.status());
  if (!followed.map_reported && !session->map().empty()) {
    followed.map_reported = true;
    v1::MapEntered entered;
    entered.set_map(session->map());
    entered.set_map_display_name(DisplayNameOf(session->map()));
    if (session->entry().has_pose_map_robot()) *entered.mutable_pose_map_robot() = session->entry().pose_map_robot();
    hooks_.on_map_entered(followed.session, entered);
  }
  const bool ended = HasEnded(*session);
  if (ended && !followed.mapped) {
    followed.mapped = true;
    NotifyMapped(followed, *session);
  }
  if (followed.awaits_survey) return session->surveyed();
  v1::ListDoorVerdictsRequest request;
  request.set_parent(convert::NameOf(convert::SessionName{robot_.site, followed.session}));
  request.set_page_size(1000);
  const auto verdicts = connection_.Call(&v1::SessionService::Stub::ListDoorVerdicts, request);
  if (!verdicts.ok()) return false;
  for (; followed.verdicts < verdicts->verdicts_size(); ++followed.verdicts) {
    NotifyVerdict(followed.session, verdicts->verdicts(followed.verdicts));
  }
  // A survey may cut the session: its later verdicts are then another session's.
  if (session->surveyed()) return true;
  const bool judged = followed.verdicts >= hooks_.expected_verdicts(followed.session);
  if (session->state() == v1::Session::STATE_MAPPED && !session->map().empty() && ServerSurveys()) {
    followed.awaits_survey = judged;
    return false;
  }
  // A session without a map is recorded only, and never mapped.
  return (followed.mapped || session->map().empty()) && judged &&
         (ended || session->entry().previous_session().empty());
}

bool SessionFollower::ServerSurveys() {
  if (!server_surveys_) {
    const auto status = connection_.Call(&v1::ServerService::Stub::GetServerStatus, v1::GetServerStatusRequest());
    if (status.ok()) server_surveys_ = status->surveys_sites();
  }
  return server_surveys_.value_or(false);
}

void SessionFollower::NotifyMapped(const Followed& followed, const v1::Session& session) {
  const std::string text =
      HasFailed(session)
          ? fmt::format("session {} could not be mapped: {}", followed.session.value(), session.error())
          : fmt::format("session {} is mapped into \"{}\"", followed.session.value(), DisplayNameOf(session.map()));
  listener_({"mapped",
             text,
             {{"session", followed.session.value()}, {"map", session.map()}, {"failed", HasFailed(session)}}});
}

void SessionFollower::NotifyVerdict(const SessionId& session, const v1::DoorVerdict& verdict) {
  std::string text = DecisionText(verdict);
  if (!verdict.link_point().empty()) text += fmt::format(" {}", LastSegment(verdict.link_point()));
  if (!verdict.entered_map().empty()) text += fmt::format(", into \"{}\"", DisplayNameOf(verdict.entered_map()));
  if (!verdict.reason().empty()) text += fmt::format(": {}", verdict.reason());
  nlohmann::json comparisons = nlohmann::json::array();
  for (const v1::DoorComparison& comparison : verdict.comparisons()) {
    comparisons.push_back({{"link_point", comparison.link_point()},
                           {"map", comparison.map()},
                           {"distance_m", comparison.distance_m()},
                           {"image_matches", comparison.image_matches()},
                           {"registration_rmse_m", comparison.registration_rmse_m()},
                           {"registration_inlier_share", comparison.registration_inlier_share()},
                           {"chi2", comparison.chi2()},
                           {"accepted", comparison.accepted()},
                           {"reason", comparison.reason()}});
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

void SessionFollower::PollGlobalPose() {
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
              {"pose_world_robot", PoseToJson(T_world_robot.x(), T_world_robot.y(), T_world_robot.yaw())},
              {"covariance", std::vector<double>(pose.pose_world_robot().covariance().begin(),
                                                 pose.pose_world_robot().covariance().end())},
              {"graph_version", pose.graph_version()}}});
}

std::string SessionFollower::DisplayNameOf(const std::string& map) {
  if (const auto known = display_names_.find(map); known != display_names_.end()) return known->second;
  v1::GetMapRequest request;
  request.set_name(map);
  const auto response = connection_.Call(&v1::MapService::Stub::GetMap, request);
  if (!response.ok()) return LastSegment(map);
  return display_names_[map] = response->map().display_name();
}

}  // namespace enfilade::robot
