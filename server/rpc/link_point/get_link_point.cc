// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/link_point/convert.h"
#include "server/rpc/link_point/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::GetLinkPointResponse> GetLinkPoint(const Services& services, const Call& call,
                                                      const v1::GetLinkPointRequest& request) {
  v1::GetLinkPointResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::LinkPointName name, convert::ParseLinkPointName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::StoredLinkPoint stored,
                            services.link_points.Get(call.context(), name.site, name.link_point));
  ENFILADE_ASSIGN_OR_RETURN(*response.mutable_link_point(), WithEvidence(services, call.context(), stored));
  return response;
}

}  // namespace enfilade::server
