// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/app/priors/plans_beside.h"
#include "server/rpc/prior/convert.h"
#include "server/rpc/prior/handlers.h"
#include "server/rpc/resources.h"
#include "storage/etag.h"

namespace enfilade::server {
namespace {

// The etags of the plans that it will be in use beside. FAILED_PRECONDITION if one of them is of the same rooms.
absl::StatusOr<std::vector<std::int64_t>> FindBeside(const Services& services, const Call& call,
                                                     const storage::PriorMap& prior_map) {
  ENFILADE_ASSIGN_OR_RETURN(
      const auto ties, ReadTies(call.context(), services.prior_maps, services.blobs, prior_map.site, prior_map.id));
  ENFILADE_ASSIGN_OR_RETURN(PlansBeside beside, FindPlansBeside(call.context(), services.prior_maps, services.blobs,
                                                                prior_map, ties.value_or(graph::PlanTies())));
  if (beside.same_area) {
    return FailedPrecondition("{} is in use and has the same walls: suspend it first",
                              NameOf(prior_map.site, *beside.same_area));
  }
  return std::move(beside.etags);
}

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
  if (etag != 0 && etag != prior_map.etag) return storage::StaleEtag(convert::NameOf(name));
  storage::PriorMapOutcome outcome{state, prior_map.reason};
  if (state == storage::PriorMapState::kActive) {
    ENFILADE_ASSIGN_OR_RETURN(outcome.beside, FindBeside(services, call, prior_map));
  }
  ENFILADE_ASSIGN_OR_RETURN(
      const auto changed,
      services.prior_maps.SetOutcome(call.context(), name.site, name.prior_map, prior_map.etag, outcome));
  services.graphs.MarkChanged(name.site);
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
