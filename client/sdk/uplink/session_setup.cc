// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/uplink/session_setup.h"

#include "client/sdk/api/maps.h"
#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/robot_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"

namespace enfilade::client {
namespace {

// OK if another client has created it meanwhile.
absl::Status CreateRobot(const Connection& connection, const SpoolSession& session) {
  v1::CreateRobotRequest request;
  request.set_parent(NameOf(session.site));
  request.set_robot_id(session.robot.value());
  request.mutable_robot()->set_display_name(session.robot.value());
  const absl::Status status = connection.Call(&v1::RobotService::Stub::CreateRobot, request).status();
  return absl::IsAlreadyExists(status) ? absl::OkStatus() : status;
}

v1::CreateMapRequest MapOf(const SpoolSession& session) {
  v1::CreateMapRequest request;
  if (IsValidResourceId(session.map)) request.set_map_id(session.map);
  request.mutable_map()->set_display_name(session.map);
  if (session.environment == Environment::kOutdoor) {
    request.mutable_map()->set_environment(v1::Map::ENVIRONMENT_OUTDOOR);
  } else if (session.environment == Environment::kIndoor) {
    request.mutable_map()->set_environment(v1::Map::ENVIRONMENT_INDOOR);
  }
  return request;
}

struct MapNames {
  std::string asked;  // resource name
  std::string now;    // of the map that it leads to
};

absl::StatusOr<MapNames> MapNamesOf(const Connection& connection, const SpoolSession& session, bool create_missing) {
  if (session.map.empty()) return MapNames{};
  const bool create = create_missing && !session.entry.T_map_robot;  // a pose in a map means that the map exists
  const absl::StatusOr<v1::Map> map = create ? FindOrCreateMap(connection, session.site, session.map, MapOf(session))
                                             : FindMap(connection, session.site, session.map);
  if (!map.ok()) return map.status();
  MapNames names{map->name(), map->name()};
  // The pose is in the frame of the map that was asked for. If that was merged into another one meanwhile, the server
  // moves the pose, but only under the old name.
  const bool by_id = map->display_name() != session.map && IsValidResourceId(session.map);
  if (session.entry.T_map_robot && by_id) {
    names.asked = convert::NameOf(convert::MapName{session.site, MapId(session.map)});
  }
  return names;
}

absl::StatusOr<v1::Session> Create(const Connection& connection, const SpoolSession& session, const std::string& map) {
  v1::CreateSessionRequest request;
  request.set_parent(NameOf(session.site));
  request.set_session_id(session.id.value());
  request.set_request_id(session.request_id);
  request.mutable_session()->set_robot(convert::NameOf(convert::RobotName{session.site, session.robot}));
  request.mutable_session()->set_map(map);
  if (session.entry.previous) {
    request.mutable_session()->mutable_entry()->set_previous_session(
        convert::NameOf(convert::SessionName{session.site, *session.entry.previous}));
  }
  if (session.entry.T_map_robot) {
    *request.mutable_session()->mutable_entry()->mutable_pose_map_robot() =
        convert::ToProto(*session.entry.T_map_robot);
  }
  if (session.entry.T_odom_robot) {
    *request.mutable_session()->mutable_entry()->mutable_pose_odom_robot() =
        convert::ToProto(*session.entry.T_odom_robot);
  }
  ENFILADE_ASSIGN_OR_RETURN(const v1::CreateSessionResponse response,
                            connection.Call(&v1::SessionService::Stub::CreateSession, request));
  return response.session();
}

}  // namespace

absl::StatusOr<v1::Session> EnsureSession(const Connection& connection, const SpoolSession& session,
                                          bool create_missing) {
  ENFILADE_ASSIGN_OR_RETURN(const MapNames map, MapNamesOf(connection, session, create_missing));
  absl::StatusOr<v1::Session> created = Create(connection, session, map.asked);
  if (create_missing && absl::IsNotFound(created.status())) {
    ENFILADE_RETURN_IF_ERROR(CreateRobot(connection, session));
    created = Create(connection, session, map.asked);
  }
  const bool asked_otherwise = absl::IsInvalidArgument(created.status());
  if (!absl::IsAlreadyExists(created.status()) && !asked_otherwise) return created;
  // Created by a request of another spool. It may still be this robot's session if its disk was replaced. Or it was
  // created by this spool when its map had another name, before that was merged into another map.
  const absl::StatusOr<v1::Session> stored = GetSession(connection, session.site, session.id);
  if (asked_otherwise && absl::IsNotFound(stored.status())) return created;
  ENFILADE_RETURN_IF_ERROR(stored.status());
  const v1::Session& found = *stored;
  if (found.robot() == convert::NameOf(convert::RobotName{session.site, session.robot}) && found.map() == map.now)
    return found;
  return AlreadyExists("session \"{}\" exists: {} records it into \"{}\"; choose another id", found.name(),
                       found.robot(), found.map());
}

absl::StatusOr<v1::Session> FinishSession(const Connection& connection, const SpoolSession& session) {
  v1::FinishSessionRequest request;
  request.set_name(convert::NameOf(convert::SessionName{session.site, session.id}));
  request.set_last_sequence(session.last_sequence);
  ENFILADE_ASSIGN_OR_RETURN(const v1::FinishSessionResponse response,
                            connection.Call(&v1::SessionService::Stub::FinishSession, request));
  return response.session();
}

absl::StatusOr<v1::Session> GetSession(const Connection& connection, const SiteId& site, const SessionId& id) {
  v1::GetSessionRequest request;
  request.set_name(convert::NameOf(convert::SessionName{site, id}));
  ENFILADE_ASSIGN_OR_RETURN(const v1::GetSessionResponse response,
                            connection.Call(&v1::SessionService::Stub::GetSession, request));
  return response.session();
}

}  // namespace enfilade::client
