// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/app/graph/map_alignment.h"
#include "server/rpc/graph/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::AlignMapsResponse> AlignMaps(const Services& services, const Call& call,
                                                const v1::AlignMapsRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName a, convert::ParseMapName("map_a", request.map_a()));
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName b, convert::ParseMapName("map_b", request.map_b()));
  if (a.site != b.site) return InvalidArgument("map_a and map_b are of different sites");
  MapAlignmentRequest wanted{a.site, a.map, b.map, std::nullopt};
  if (request.has_pose_a_b()) wanted.T_a_b = convert::FromProto(request.pose_a_b());
  if (request.radius_m() != 0.0) wanted.radius = request.radius_m();
  if (request.yaw_range_rad() != 0.0) wanted.yaw_range = request.yaw_range_rad();
  ENFILADE_ASSIGN_OR_RETURN(
      const localization::MapAlignment found,
      AlignStoredMaps(call.context(), {services.maps, services.revisions}, services.graphs, wanted));
  v1::AlignMapsResponse response;
  response.set_accepted(found.accepted);
  response.set_reason(found.reason);
  if (!found.T_a_b) return response;
  *response.mutable_pose_a_b() = convert::ToProto(*found.T_a_b);
  response.set_score(found.score);
  response.set_overlap_m2(found.overlap);
  response.set_rival_ratio(found.rival_ratio);
  response.mutable_place_a()->set_x(found.place_a.x());
  response.mutable_place_a()->set_y(found.place_a.y());
  return response;
}

}  // namespace enfilade::server
