// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/link_point/convert.h"
#include "server/rpc/link_point/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
absl::StatusOr<v1::UpdateLinkPointResponse> UpdateLinkPoint(const Services& services, const Call& call,
                                                            const v1::UpdateLinkPointRequest& request) {
  v1::UpdateLinkPointResponse response;
  const auto& mask = request.update_mask();
  ENFILADE_RETURN_IF_ERROR(CheckLinkPointMask(mask));
  ENFILADE_ASSIGN_OR_RETURN(const convert::LinkPointName name,
                            convert::ParseLinkPointName("link_point.name", request.link_point().name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.link_point().etag()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::StoredLinkPoint stored,
                            services.link_points.Get(call.context(), name.site, name.link_point));
  v1::LinkPoint wanted = ToProto(stored);
  Overwrite(request.link_point(), mask, wanted);
  ENFILADE_ASSIGN_OR_RETURN(storage::StoredLinkPoint link_point, FromProto(name.site, wanted));
  link_point.point.id = name.link_point;
  link_point.forced = stored.forced;
  link_point.etag = etag != 0 ? etag : stored.etag;
  ENFILADE_ASSIGN_OR_RETURN(const storage::StoredLinkPoint changed,
                            services.graph_editor.UpdateLinkPoint(call.context(), link_point));
  ENFILADE_ASSIGN_OR_RETURN(*response.mutable_link_point(), WithEvidence(services, call.context(), changed));
  return response;
}

}  // namespace enfilade::server
