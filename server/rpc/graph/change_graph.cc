// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/graph/given_changes.h"
#include "server/rpc/graph/handlers.h"
#include "server/rpc/link_point/convert.h"

namespace enfilade::server {

absl::StatusOr<v1::ChangeGraphResponse> ChangeGraph(const Services& services, const Call& call,
                                                    const v1::ChangeGraphRequest& request) {
  v1::ChangeGraphResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("site", request.site()));
  const auto find = [&](const LinkPointId& id) { return services.link_points.Get(call.context(), site, id); };
  ENFILADE_ASSIGN_OR_RETURN(const GivenChanges given, ParseChanges(site, request.changes(), find));
  ENFILADE_ASSIGN_OR_RETURN(const storage::ChangedLinkPoints changed,
                            services.graph_editor.ChangeLinkPoints(call.context(), site, given.changes));
  response.set_graph_version(changed.graph_version);
  ENFILADE_ASSIGN_OR_RETURN(std::vector<v1::LinkPoint> link_points,
                            WithEvidence(services, call.context(), site, changed.link_points));
  for (v1::LinkPoint& link_point : link_points) *response.add_link_points() = std::move(link_point);
  return response;
}

}  // namespace enfilade::server
