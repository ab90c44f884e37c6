// SPDX-License-Identifier: Apache-2.0
#include "server/app/rearrange/map_rearrangements.h"

#include <chrono>
#include <utility>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "server/app/graph/held_site_lease.h"
#include "storage/sessions/all_sessions.h"

namespace enfilade::server {
namespace {

constexpr auto kRearrangeLeaseTime = std::chrono::seconds(60);
// The optimiser or a robot may change the graph between a decision and its application.
constexpr int kPlanAttempts = 10;

}  // namespace

MapRearrangements::MapRearrangements(const Rearranger::Stores& stores, const storage::SiteLeaseStore& leases,
                                     const Rearranger& rearranger, SiteGraphs& graphs, std::string map_name)
    : stores_(stores),
      leases_(leases),
      rearranger_(rearranger),
      graphs_(graphs),
      map_name_(std::move(map_name)),
      owner_("rearranger " + NewUuid()) {}

absl::StatusOr<storage::StoredRearrangement> MapRearrangements::Apply(const storage::CallContext& context,
                                                                      const SiteId& site, const Merge& merge) const {
  return PlanAndApply(context, site,
                      [&](const graph::GraphSnapshot& graph) -> absl::StatusOr<rearrange::Rearrangement> {
                        rearrange::MergeRequest request;
                        ENFILADE_ASSIGN_OR_RETURN(request.kept, ReadContent(context, site, merge.kept, false));
                        ENFILADE_ASSIGN_OR_RETURN(request.merged, ReadContent(context, site, merge.merged, false));
                        request.T_kept_merged = merge.T_kept_merged;
                        return rearrange::PlanMerge(request, graph);
                      });
}

absl::StatusOr<storage::StoredRearrangement> MapRearrangements::Apply(const storage::CallContext& context,
                                                                      const SiteId& site, const Split& split) const {
  return PlanAndApply(
      context, site, [&](const graph::GraphSnapshot& graph) -> absl::StatusOr<rearrange::Rearrangement> {
        rearrange::SplitRequest request;
        ENFILADE_ASSIGN_OR_RETURN(request.map, ReadContent(context, site, split.map, true));
        request.leaving = split.leaving;
        request.cuts = split.cuts;
        request.seed = {split.new_map, map_name_, request.map.level, request.map.environment, request.map.slam_profile};
        request.link_point = LinkPointId(NewUuid());
        return rearrange::PlanSplit(request, graph);
      });
}

absl::StatusOr<storage::StoredRearrangement> MapRearrangements::Undo(const storage::CallContext& context,
                                                                     const SiteId& site,
                                                                     const rearrange::RearrangementId& id) const {
  ENFILADE_ASSIGN_OR_RETURN(const HeldSiteLease lease,
                            HeldSiteLease::Await(leases_, context, site, owner_, kRearrangeLeaseTime, nullptr));
  return rearranger_.Undo(context, *lease, id);
}

absl::StatusOr<storage::StoredRearrangement> MapRearrangements::PlanAndApply(const storage::CallContext& context,
                                                                             const SiteId& site,
                                                                             const Plan& plan) const {
  ENFILADE_ASSIGN_OR_RETURN(const HeldSiteLease lease,
                            HeldSiteLease::Await(leases_, context, site, owner_, kRearrangeLeaseTime, nullptr));
  absl::StatusOr<storage::StoredRearrangement> applied = Aborted("the graph of {} keeps changing", NameOf(site));
  for (int attempt = 0; attempt < kPlanAttempts && absl::IsAborted(applied.status()); ++attempt) {
    if (attempt > 0) graphs_.MarkChanged(site);
    const auto graph = graphs_.Get(context, site);
    ENFILADE_RETURN_IF_ERROR(graph.status());
    const auto planned = plan((*graph)->graph());
    applied = planned.ok() ? rearranger_.Apply(context, *lease, *planned, (*graph)->graph().version(), true)
                           : absl::StatusOr<storage::StoredRearrangement>(planned.status());
  }
  return applied;
}

absl::StatusOr<rearrange::MapContent> MapRearrangements::ReadContent(const storage::CallContext& context,
                                                                     const SiteId& site, const MapId& id,
                                                                     bool with_keyframes) const {
  ENFILADE_ASSIGN_OR_RETURN(const storage::Map map, stores_.maps.Get(context, site, id));
  if (map.id != id) {
    return FailedPrecondition("{} was merged into {} already", NameOf(site, id), NameOf(site, map.id));
  }
  rearrange::MapContent content{map.id, map.display_name, map.level, map.environment, map.slam_profile, {}};
  ENFILADE_ASSIGN_OR_RETURN(
      const std::vector<storage::Session> sessions,
      storage::ListAllSessions(stores_.sessions, context, site, {.robot = {}, .map = map.id, .state = {}}));
  for (const storage::Session& session : sessions) {
    rearrange::SessionInMap& in_map = content.sessions.emplace_back();
    in_map.id = session.id;
    in_map.mapped = session.state == storage::SessionState::kMapped || session.state == storage::SessionState::kFailed;
    if (!with_keyframes) continue;
    ENFILADE_ASSIGN_OR_RETURN(const auto nodes, stores_.mappings.ListKeyframes(context, site, session.id));
    for (const slam::SlamNode& node : nodes) {
      in_map.keyframes.push_back({node.sequence, node.time, node.T_map_node.translation()});
    }
  }
  return content;
}

}  // namespace enfilade::server
