// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/prior/convert.h"
#include "server/rpc/prior/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::UpdatePriorMapResponse> UpdatePriorMap(const Services& services, const Call& call,
                                                          const v1::UpdatePriorMapRequest& request) {
  v1::UpdatePriorMapResponse response;
  const v1::PriorMap& wanted = request.prior_map();
  ENFILADE_RETURN_IF_ERROR(CheckMask(request.update_mask(), {"display_name"}));
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParsePriorMapName("prior_map.name", wanted.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(wanted.etag()));
  if (!IsUpdated(request.update_mask(), "display_name", !wanted.display_name().empty())) {
    ENFILADE_ASSIGN_OR_RETURN(const auto as_it_is, services.prior_maps.Get(call.context(), name.site, name.prior_map));
    *response.mutable_prior_map() = ToProto(as_it_is);
    return response;
  }
  ENFILADE_RETURN_IF_ERROR(CheckDisplayName("prior_map.display_name", wanted.display_name()));
  ENFILADE_ASSIGN_OR_RETURN(const auto renamed, services.prior_maps.Rename(call.context(), name.site, name.prior_map,
                                                                           etag, wanted.display_name()));
  *response.mutable_prior_map() = ToProto(renamed);
  return response;
}

}  // namespace enfilade::server
