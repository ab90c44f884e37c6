// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/rpc/rearrange/handlers.h"
#include "server/rpc/rearrange/messages.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::MergeMapsResponse> MergeMaps(const Services& services, const Call& call,
                                                const v1::MergeMapsRequest& request) {
  v1::MergeMapsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName kept, convert::ParseMapName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const convert::MapName merged, convert::ParseMapName("merged_map", request.merged_map()));
  if (merged.site != kept.site) return InvalidArgument("name and merged_map are of different sites");
  MapRearrangements::Merge merge{kept.map, merged.map, {}};
  if (request.has_pose_name_merged()) merge.T_kept_merged = convert::FromProto(request.pose_name_merged());
  ENFILADE_ASSIGN_OR_RETURN(const storage::StoredRearrangement applied,
                            services.rearrangements.Apply(call.context(), kept.site, merge));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map map, services.maps.Get(call.context(), kept.site, kept.map));
  *response.mutable_rearrangement() = ToProto(applied);
  *response.mutable_map() = ToProto(map);
  return response;
}

}  // namespace enfilade::server
