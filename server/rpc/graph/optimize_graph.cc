// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/graph/handlers.h"

namespace enfilade::server {

absl::StatusOr<v1::OptimizeGraphResponse> OptimizeGraph(const Services& services, const Call& call,
                                                        const v1::OptimizeGraphRequest& request) {
  v1::OptimizeGraphResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("site", request.site()));
  ENFILADE_ASSIGN_OR_RETURN(const OptimizedGraph optimized, services.graph_optimizer.Optimize(call.context(), site));
  const graph::SolvedGraph& solution = optimized.solution;
  response.set_graph_version(optimized.version);
  response.set_solved_version(solution.graph_version);
  response.set_chi2_before(solution.chi2_before);
  response.set_chi2_after(solution.chi2_after);
  response.set_degrees_of_freedom(solution.degrees_of_freedom);
  response.set_iterations(solution.iterations);
  response.set_converged(solution.converged);
  response.set_maps(static_cast<std::int32_t>(solution.map_poses.size()));
  for (const graph::SwitchedOff& off : solution.switched_off) {
    v1::SwitchedOffLinkPoint& message = *response.add_switched_off();
    message.set_link_point(convert::NameOf(convert::LinkPointName{site, off.link_point}));
    message.set_chi2(off.chi2);
    message.set_gate(off.gate);
  }
  for (const MapId& map : solution.disconnected)
    response.add_disconnected_maps(convert::NameOf(convert::MapName{site, map}));
  return response;
}

}  // namespace enfilade::server
