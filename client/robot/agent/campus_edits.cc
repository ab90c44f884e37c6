// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/campus_edits.h"

#include "client/sdk/api/maps.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "proto/convert/names.h"

namespace enfilade::robot {

absl::Status DeleteMapOnServer(const client::Connection& connection, const SiteId& site, const std::string& map) {
  ENFILADE_ASSIGN_OR_RETURN(const v1::Map found, client::FindMap(connection, site, map));
  v1::DeleteMapRequest request;
  request.set_name(found.name());
  return connection.Call(&v1::MapService::Stub::DeleteMap, request).status();
}

absl::Status DeleteLinkPointOnServer(const client::Connection& connection, const SiteId& site,
                                     const std::string& link_point) {
  v1::DeleteLinkPointRequest request;
  request.set_name(IsValidResourceId(link_point)
                       ? convert::NameOf(convert::LinkPointName{site, LinkPointId(link_point)})
                       : link_point);
  return connection.Call(&v1::LinkPointService::Stub::DeleteLinkPoint, request).status();
}

}  // namespace enfilade::robot
