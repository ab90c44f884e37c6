// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <memory>
#include <numeric>
#include <vector>

#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/graph/graph_optimization.h"
#include "core/graph/plans/plan_ties.h"
#include "proto/convert/geometry.h"
#include "server/rpc/paging.h"
#include "server/rpc/prior/handlers.h"
#include "server/rpc/prior/product_file.h"

namespace enfilade::server {
namespace {

// Of the plan in use: how its ties fit. Empty if the graph has no such plan.
absl::StatusOr<graph::PlanUse> UseOf(const graph::GraphSnapshot& graph, const graph::PlanInGraph* plan) {
  if (plan == nullptr || graph.root().empty()) return graph::PlanUse();
  ENFILADE_ASSIGN_OR_RETURN(const graph::SolvedGraph solution, graph::OptimizeGraph(graph));
  for (const graph::PlanUse& use : solution.plans) {
    if (use.plan == plan->id) return use;
  }
  return graph::PlanUse();
}

v1::PriorAssociation ToProto(const SiteId& site, const graph::PlanTies& ties, const graph::WallSighting& sighting,
                             const graph::SightingUse& use) {
  v1::PriorAssociation out;
  out.set_wall(ties.struts[static_cast<std::size_t>(sighting.strut)].wall);
  out.set_map(NameOf(site, sighting.map));
  *out.mutable_pose_map_line() = convert::ToProto(sighting.T_map_line);
  out.set_length_m(sighting.length);
  out.set_state(!use.is_part ? v1::PriorAssociation::STATE_UNUSED
                : use.used   ? v1::PriorAssociation::STATE_USED
                             : v1::PriorAssociation::STATE_SWITCHED_OFF);
  out.set_across_m(use.across);
  out.set_turn_rad(use.turn);
  out.set_chi2(use.chi2);
  return out;
}

v1::PriorShaft ToProto(const SiteId& site, const graph::ShaftUse& use) {
  v1::PriorShaft out;
  out.set_name(use.name);
  out.set_other_prior_map(NameOf(site, use.other));
  out.set_state(use.used ? v1::PriorAssociation::STATE_USED : v1::PriorAssociation::STATE_SWITCHED_OFF);
  out.set_distance_m(use.distance);
  out.set_chi2(use.chi2);
  return out;
}

}  // namespace

absl::StatusOr<v1::ListPriorAssociationsResponse> ListPriorAssociations(
    const Services& services, const Call& call, const v1::ListPriorAssociationsRequest& request) {
  v1::ListPriorAssociationsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParsePriorMapName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t first, FromNumericPageToken(request.page_token(), 0));
  ENFILADE_ASSIGN_OR_RETURN(const std::string bytes,
                            ReadProductFile(services, call, name, storage::PriorMapProduct::kTies, "ties.bin"));
  ENFILADE_ASSIGN_OR_RETURN(const auto graph, services.graphs.Get(call.context(), name.site));
  const auto& plans = graph->graph().plans();
  const auto plan =
      std::find_if(plans.begin(), plans.end(), [&](const graph::PlanInGraph& one) { return one.id == name.prior_map; });
  std::shared_ptr<const graph::PlanTies> ties;
  if (plan != plans.end()) {
    ties = plan->ties;
  } else {
    ENFILADE_ASSIGN_OR_RETURN(graph::PlanTies decoded, graph::DecodePlanTies(bytes));
    ENFILADE_ASSIGN_OR_RETURN(const auto prior_map, services.prior_maps.Get(call.context(), name.site, name.prior_map));
    if (prior_map.alignment) decoded.KeepMaps(prior_map.alignment->maps);
    ties = std::make_shared<const graph::PlanTies>(std::move(decoded));
  }
  ENFILADE_ASSIGN_OR_RETURN(graph::PlanUse use, UseOf(graph->graph(), plan == plans.end() ? nullptr : &*plan));
  std::vector<graph::SightingUse>& uses = use.sightings;
  uses.resize(ties->sightings.size());
  std::vector<std::size_t> order(ties->sightings.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](std::size_t i) {
    const graph::WallSighting& sighting = ties->sightings[i];
    return std::pair(sighting.map, ties->struts[static_cast<std::size_t>(sighting.strut)].wall);
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  const auto begin = std::min(order.size(), static_cast<std::size_t>(std::max<std::int64_t>(first, 0)));
  const std::size_t end = std::min(order.size(), begin + static_cast<std::size_t>(size));
  for (std::size_t i = begin; i < end; ++i) {
    *response.add_associations() = ToProto(name.site, *ties, ties->sightings[order[i]], uses[order[i]]);
  }
  if (begin == 0) {
    for (const graph::ShaftUse& shaft : use.shafts) *response.add_shafts() = ToProto(name.site, shaft);
  }
  if (end < order.size()) response.set_next_page_token(ToPageToken(std::to_string(end)));
  return response;
}

}  // namespace enfilade::server
