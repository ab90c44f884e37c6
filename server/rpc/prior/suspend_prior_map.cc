// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/prior/convert.h"
#include "server/rpc/prior/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
namespace {

template <typename Response, typename Request>
absl::StatusOr<Response> SetState(const Services& services, const Call& call, const Request& request,
                                  storage::PriorMapState state) {
  Response response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParsePriorMapName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.etag()));
  ENFILADE_ASSIGN_OR_RETURN(const auto prior_map, services.prior_maps.Get(call.context(), name.site, name.prior_map));
  const bool holds =
      prior_map.state != storage::PriorMapState::kNew && prior_map.state != storage::PriorMapState::kDiverged;
  if (!prior_map.alignment || !holds) {
    return FailedPrecondition("{} has no alignment that holds: {}. Align it first", convert::NameOf(name),
                              prior_map.reason);
  }
  ENFILADE_ASSIGN_OR_RETURN(const auto changed,
                            services.prior_maps.SetState(call.context(), name.site, name.prior_map,
                                                         etag != 0 ? etag : prior_map.etag, state, prior_map.reason));
  *response.mutable_prior_map() = ToProto(changed);
  return response;
}

}  // namespace

absl::StatusOr<v1::ActivatePriorMapResponse> ActivatePriorMap(const Services& services, const Call& call,
                                                              const v1::ActivatePriorMapRequest& request) {
  return SetState<v1::ActivatePriorMapResponse>(services, call, request, storage::PriorMapState::kActive);
}

absl::StatusOr<v1::SuspendPriorMapResponse> SuspendPriorMap(const Services& services, const Call& call,
                                                            const v1::SuspendPriorMapRequest& request) {
  return SetState<v1::SuspendPriorMapResponse>(services, call, request, storage::PriorMapState::kSuspended);
}

}  // namespace enfilade::server
