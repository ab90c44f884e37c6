// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>
#include <vector>

#include "core/base/status_macros.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "server/rpc/graph/handlers.h"
#include "server/rpc/paging.h"

namespace enfilade::server {
namespace {

constexpr std::int32_t kDefaultPageSize = 1000;

}  // namespace

absl::StatusOr<v1::ListPlacedMapsResponse> ListPlacedMaps(const Services& services, const Call& call,
                                                          const v1::ListPlacedMapsRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size,
                            PageSize(request.page_size() == 0 ? kDefaultPageSize : request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::string token, FromPageToken(request.page_token()));
  ENFILADE_RETURN_IF_ERROR(services.sites.Get(call.context(), site).status());
  ENFILADE_ASSIGN_OR_RETURN(
      auto poses, services.graph_store.GetMapPoses(call.context(), site, request.graph_version(), /*since=*/0));
  std::erase_if(poses.posed, [&](const storage::MapPose& pose) { return pose.map.value() <= token; });
  std::sort(poses.posed.begin(), poses.posed.end(),
            [](const storage::MapPose& a, const storage::MapPose& b) { return a.map < b.map; });
  v1::ListPlacedMapsResponse response;
  if (CutToPage(poses.posed, size)) response.set_next_page_token(ToPageToken(poses.posed.back().map.value()));
  for (const storage::MapPose& pose : poses.posed) {
    v1::PlacedMap& out = *response.add_placed_maps();
    out.set_map(convert::NameOf(convert::MapName{site, pose.map}));
    enfilade::convert::ToProto(pose.T_world_map, *out.mutable_pose_world_map());
  }
  return response;
}

}  // namespace enfilade::server
