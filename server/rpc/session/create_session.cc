// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/rpc/resources.h"
#include "server/rpc/session/handlers.h"

namespace enfilade::server {
namespace {

absl::Status CheckSameSite(const char* field, const SiteId& named, const SiteId& parent) {
  if (named == parent) return absl::OkStatus();
  return InvalidArgument("{} is of site \"{}\", the session of \"{}\": they must be the same", field, named.value(),
                         parent.value());
}

absl::StatusOr<sensor::SessionEntry> EntryFromProto(const v1::Session& session, const SiteId& site) {
  sensor::SessionEntry entry;
  const v1::SessionEntry& in = session.entry();
  if (!in.previous_session().empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const convert::SessionName previous,
                              convert::ParseSessionName("session.entry.previous_session", in.previous_session()));
    ENFILADE_RETURN_IF_ERROR(CheckSameSite("session.entry.previous_session", previous.site, site));
    if (!session.map().empty() || in.has_pose_map_robot() || in.has_pose_odom_robot()) {
      return InvalidArgument(
          "session.entry.previous_session is set: session.map and the entry's poses must be left empty, as they follow "
          "from how the previous session ends");
    }
    entry.previous = previous.session;
    return entry;
  }
  if (in.has_pose_map_robot()) {
    if (session.map().empty()) return InvalidArgument("session.entry.pose_map_robot is set, but session.map is not");
    ENFILADE_ASSIGN_OR_RETURN(entry.T_map_robot,
                              enfilade::convert::FromProto("session.entry.pose_map_robot", in.pose_map_robot()));
  }
  if (in.has_pose_odom_robot()) {
    if (!in.has_pose_map_robot()) {
      return InvalidArgument("session.entry.pose_odom_robot is set, but pose_map_robot is not");
    }
    entry.T_odom_robot = enfilade::convert::FromProto(in.pose_odom_robot());
    if (!IsFinite(*entry.T_odom_robot)) return InvalidArgument("session.entry.pose_odom_robot is not finite");
  }
  return entry;
}

}  // namespace

absl::StatusOr<v1::CreateSessionResponse> CreateSession(const Services& services, const Call& call,
                                                        const v1::CreateSessionRequest& request) {
  v1::CreateSessionResponse response;
  storage::Session session;
  ENFILADE_ASSIGN_OR_RETURN(session.site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const convert::RobotName robot,
                            convert::ParseRobotName("session.robot", request.session().robot()));
  ENFILADE_RETURN_IF_ERROR(CheckSameSite("session.robot", robot.site, session.site));
  session.robot = robot.robot;
  if (!request.session().map().empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const convert::MapName map,
                              convert::ParseMapName("session.map", request.session().map()));
    ENFILADE_RETURN_IF_ERROR(CheckSameSite("session.map", map.site, session.site));
    session.map = map.map;
  }
  if (request.session().has_entry()) {
    ENFILADE_ASSIGN_OR_RETURN(session.entry, EntryFromProto(request.session(), session.site));
  }
  ENFILADE_ASSIGN_OR_RETURN(std::string id, IdOrNew("session_id", request.session_id()));
  session.id = SessionId(std::move(id));
  ENFILADE_ASSIGN_OR_RETURN(const storage::RequestId request_id, RequestIdOf(request));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Session created,
                            services.sessions.Create(call.context(), session, request_id));
  // The door through which the robot has come may be judged already.
  if (created.entry.previous && !created.map) services.doors_wake.Wake();
  *response.mutable_session() = ToProto(created);
  return response;
}

}  // namespace enfilade::server
