// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/link_point/convert.h"
#include "server/rpc/link_point/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::CreateLinkPointResponse> CreateLinkPoint(const Services& services, const Call& call,
                                                            const v1::CreateLinkPointRequest& request) {
  v1::CreateLinkPointResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(storage::StoredLinkPoint link_point, FromProto(site, request.link_point()));
  ENFILADE_ASSIGN_OR_RETURN(std::string id, IdOrNew("link_point_id", request.link_point_id()));
  link_point.point.id = LinkPointId(std::move(id));
  link_point.forced = request.force();
  ENFILADE_ASSIGN_OR_RETURN(const storage::RequestId request_id, RequestIdOf(request));
  ENFILADE_ASSIGN_OR_RETURN(const storage::StoredLinkPoint created,
                            services.graph_editor.CreateLinkPoint(call.context(), link_point, request_id));
  *response.mutable_link_point() = ToProto(created);
  return response;
}

}  // namespace enfilade::server
