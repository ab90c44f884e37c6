// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/graph/handlers.h"
#include "server/rpc/graph/messages.h"

namespace enfilade::server {

absl::StatusOr<v1::GetGeoreferenceResponse> GetGeoreference(const Services& services, const Call& call,
                                                            const v1::GetGeoreferenceRequest& request) {
  v1::GetGeoreferenceResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("site", request.site()));
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, services.graphs.Get(call.context(), site));
  if (graph->control_points.empty()) return NotFound("{} has no georeference", NameOf(site));
  // Fits again instead of using the graph's: if it does not fit, the error says why.
  ENFILADE_ASSIGN_OR_RETURN(const geo::GeoreferenceFit fit, FitControlPoints(graph->poses, graph->control_points));
  *response.mutable_georeference() = ToProto(site, *graph, fit, graph->control_points);
  return response;
}

}  // namespace enfilade::server
