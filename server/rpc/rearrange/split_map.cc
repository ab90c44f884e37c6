// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "proto/convert/names.h"
#include "server/rpc/rearrange/handlers.h"
#include "server/rpc/rearrange/messages.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
namespace {

absl::StatusOr<SessionId> SessionOf(const char* field, const std::string& name, const SiteId& site) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::SessionName session, convert::ParseSessionName(field, name));
  if (session.site != site) return InvalidArgument("{} is \"{}\": it is not of the map's site", field, name);
  return session.session;
}

}  // namespace

absl::StatusOr<v1::SplitMapResponse> SplitMap(const Services& services, const Call& call,
                                              const v1::SplitMapRequest& request) {
  v1::SplitMapResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName name, convert::ParseMapName("name", request.name()));
  MapRearrangements::Split split;
  split.map = name.map;
  for (const std::string& session : request.sessions()) {
    ENFILADE_ASSIGN_OR_RETURN(SessionId id, SessionOf("sessions", session, name.site));
    split.leaving.push_back(std::move(id));
  }
  for (const v1::SessionCut& cut : request.cuts()) {
    ENFILADE_ASSIGN_OR_RETURN(SessionId id, SessionOf("cuts.session", cut.session(), name.site));
    split.cuts.push_back({std::move(id), cut.first_sequence(), SessionId(NewUuid())});
  }
  ENFILADE_ASSIGN_OR_RETURN(std::string map_id, IdOrNew("map_id", request.map_id()));
  split.new_map = MapId(std::move(map_id));
  ENFILADE_ASSIGN_OR_RETURN(const storage::StoredRearrangement applied,
                            services.rearrangements.Apply(call.context(), name.site, split));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map map, services.maps.Get(call.context(), name.site, split.new_map));
  *response.mutable_rearrangement() = ToProto(applied);
  *response.mutable_map() = ToProto(map);
  return response;
}

}  // namespace enfilade::server
