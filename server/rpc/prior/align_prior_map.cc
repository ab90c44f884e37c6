// SPDX-License-Identifier: Apache-2.0
#include <chrono>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/prior/convert.h"
#include "server/rpc/prior/handlers.h"
#include "server/rpc/resources.h"
#include "storage/etag.h"

namespace enfilade::server {
namespace {

constexpr auto kTimeToStore = std::chrono::seconds(10);

}  // namespace

absl::StatusOr<v1::AlignPriorMapResponse> AlignPriorMap(const Services& services, const Call& call,
                                                        const v1::AlignPriorMapRequest& request) {
  v1::AlignPriorMapResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParsePriorMapName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.etag()));
  ENFILADE_ASSIGN_OR_RETURN(const auto pairs, PairsOf(name.site, request.pairs()));
  ENFILADE_ASSIGN_OR_RETURN(storage::PriorMap prior_map,
                            services.prior_maps.Get(call.context(), name.site, name.prior_map));
  if (etag != 0 && etag != prior_map.etag) return storage::StaleEtag(convert::NameOf(name));
  if (request.from_last() && !pairs.empty()) return InvalidArgument("from_last: expected no pairs with it");
  if (request.from_last() && !prior_map.alignment) {
    return FailedPrecondition("{} was never aligned", convert::NameOf(name));
  }
  ENFILADE_ASSIGN_OR_RETURN(
      const AlignedPriorMap aligned,
      services.prior_alignment.Align(call.context(), prior_map, pairs, request.from_last(), request.activate()));
  for (const double residual : aligned.pair_residuals) response.add_pair_residuals_m(residual);
  if (request.validate_only()) {
    prior_map.state = aligned.outcome.state;
    prior_map.reason = aligned.outcome.reason;
    if (aligned.outcome.alignment) prior_map.alignment = aligned.outcome.alignment;
    *response.mutable_prior_map() = ToProto(prior_map);
    return response;
  }
  // What was computed is of the prior map as it was read. It is not thrown away because the client has not waited.
  storage::CallContext context = storage::CallContext::WithTimeout(kTimeToStore);
  context.actor = call.context().actor;
  ENFILADE_ASSIGN_OR_RETURN(
      const storage::PriorMap stored,
      services.prior_maps.SetOutcome(context, name.site, name.prior_map, prior_map.etag, aligned.outcome));
  services.graphs.MarkChanged(name.site);  // plans of other levels may be aligned by this one next
  *response.mutable_prior_map() = ToProto(stored);
  return response;
}

}  // namespace enfilade::server
