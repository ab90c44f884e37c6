// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/prior/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::DeletePriorMapResponse> DeletePriorMap(const Services& services, const Call& call,
                                                          const v1::DeletePriorMapRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParsePriorMapName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.etag()));
  ENFILADE_RETURN_IF_ERROR(
      services.prior_maps.Delete(call.context(), name.site, name.prior_map, etag, request.force()));
  return v1::DeletePriorMapResponse();
}

}  // namespace enfilade::server
