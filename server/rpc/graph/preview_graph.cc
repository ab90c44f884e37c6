// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <string>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "proto/convert/geometry.h"
#include "proto/convert/names.h"
#include "server/app/graph/graph_preview.h"
#include "server/rpc/graph/given_changes.h"
#include "server/rpc/graph/handlers.h"

namespace enfilade::server {
namespace {

void Fill(const SiteId& site, const graph::MovedMap& moved, v1::MovedMap& out) {
  out.set_map(NameOf(site, moved.map));
  if (moved.T_world_map_before) {
    enfilade::convert::ToProto(*moved.T_world_map_before, *out.mutable_pose_world_map_before());
  }
  if (moved.T_world_map_after) {
    enfilade::convert::ToProto(*moved.T_world_map_after, *out.mutable_pose_world_map_after());
  }
}

// What is made without a name has that of its change.
std::string NameInPreview(const SiteId& site, const GivenChanges& given, const LinkPointId& id) {
  const auto unnamed = given.unnamed.find(id);
  return unnamed == given.unnamed.end() ? NameOf(site, id)
                                        : NameOf(site, LinkPointId(fmt::format("new-{}", unnamed->second)));
}

void Fill(const graph::ResidualChange& residual, v1::LinkPointResidual& out) {
  out.set_chi2_before(residual.chi2_before);
  out.set_chi2_after(residual.chi2_after);
  out.set_gate(residual.gate);
  out.set_switched_off_before(residual.switched_off_before);
  out.set_switched_off_after(residual.switched_off_after);
}

v1::PreviewGraphResponse ToProto(const SiteId& site, const GivenChanges& given, const GraphPreview& preview) {
  v1::PreviewGraphResponse response;
  for (const graph::MovedMap& moved : preview.difference.moved) Fill(site, moved, *response.add_moved_maps());
  response.set_chi2_before(preview.before->chi2_after);
  response.set_chi2_after(preview.after->chi2_after);
  response.set_degrees_of_freedom(preview.after->degrees_of_freedom);
  for (const graph::ResidualChange& residual : preview.difference.residuals) {
    v1::LinkPointResidual& out = *response.add_residuals();
    out.set_link_point(NameInPreview(site, given, residual.link_point));
    Fill(residual, out);
  }
  for (const MapId& map : preview.after->disconnected) response.add_disconnected_maps(NameOf(site, map));
  return response;
}

}  // namespace

absl::StatusOr<v1::PreviewGraphResponse> PreviewGraph(const Services& services, const Call& call,
                                                      const v1::PreviewGraphRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("site", request.site()));
  ENFILADE_ASSIGN_OR_RETURN(const std::shared_ptr<const SiteGraph> graph, services.graphs.Get(call.context(), site));
  const auto find = [&](const LinkPointId& id) -> absl::StatusOr<storage::StoredLinkPoint> {
    const int slot = graph->graph().LinkPointSlot(id);
    if (slot < 0) return NotFound("{} does not exist", NameOf(site, id));
    return graph->placed.Get(slot);
  };
  ENFILADE_ASSIGN_OR_RETURN(const GivenChanges given, ParseChanges(site, request.changes(), find));
  ENFILADE_ASSIGN_OR_RETURN(const auto before, services.graph_optimizer.Solve(site, graph->graph()));
  ENFILADE_ASSIGN_OR_RETURN(const GraphPreview preview, PreviewChanges(site, *graph, before, given.changes));
  v1::PreviewGraphResponse response = ToProto(site, given, preview);
  response.set_graph_version(graph->graph().version());
  return response;
}

}  // namespace enfilade::server
