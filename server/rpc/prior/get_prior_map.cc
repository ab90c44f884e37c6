// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/prior/convert.h"
#include "server/rpc/prior/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::GetPriorMapResponse> GetPriorMap(const Services& services, const Call& call,
                                                    const v1::GetPriorMapRequest& request) {
  v1::GetPriorMapResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParsePriorMapName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const auto prior_map, services.prior_maps.Get(call.context(), name.site, name.prior_map));
  *response.mutable_prior_map() = ToProto(prior_map);
  return response;
}

}  // namespace enfilade::server
