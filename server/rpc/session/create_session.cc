#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/session/handlers.h"

namespace enfilade::server {
namespace {

absl::Status CheckSameSite(const char* field, const SiteId& named, const SiteId& parent) {
  if (named == parent) return absl::OkStatus();
  return InvalidArgument("{} is of site \"{}\", the session of \"{}\": they must be the same", field, named.value(),
                         parent.value());
}

}  // namespace

absl::StatusOr<v1::CreateSessionResponse> CreateSession(const Services& services, const CallContext& context,
                                                        const v1::CreateSessionRequest& request) {
  v1::CreateSessionResponse response;
  Session session;
  ENFILADE_ASSIGN_OR_RETURN(session.site, ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const RobotName robot, ParseRobotName("session.robot", request.session().robot()));
  ENFILADE_RETURN_IF_ERROR(CheckSameSite("session.robot", robot.site, session.site));
  session.robot = robot.robot;
  if (!request.session().map().empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const MapName map, ParseMapName("session.map", request.session().map()));
    ENFILADE_RETURN_IF_ERROR(CheckSameSite("session.map", map.site, session.site));
    session.map = map.map;
  }
  ENFILADE_ASSIGN_OR_RETURN(std::string id, IdOrNew("session_id", request.session_id()));
  session.id = SessionId(std::move(id));
  ENFILADE_ASSIGN_OR_RETURN(const Session created, services.sessions.Create(context, session, request.request_id()));
  *response.mutable_session() = ToProto(created);
  return response;
}

}  // namespace enfilade::server
