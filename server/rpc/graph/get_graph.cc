// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/graph/handlers.h"
#include "server/rpc/graph/messages.h"

namespace enfilade::server {

absl::StatusOr<v1::GetGraphResponse> GetGraph(const Services& services, const Call& call,
                                              const v1::GetGraphRequest& request) {
  v1::GetGraphResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("site", request.site()));
  if (request.graph_version() < 0) return InvalidArgument("graph_version is {}: negative", request.graph_version());
  ENFILADE_ASSIGN_OR_RETURN(const auto graph,
                            services.graphs.GetVersion(call.context(), site, request.graph_version()));
  *response.mutable_graph() = ToProto(site, *graph);
  return response;
}

}  // namespace enfilade::server
