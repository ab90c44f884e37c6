// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/site_graph_reader.h"

#include <algorithm>
#include <utility>

#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/graph/plans/plan_ties.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

// What has to be applied to a snapshot at an earlier version.
struct GraphUpdate {
  storage::GraphChanges changes;
  std::int64_t solution_version = 0;  // of the last optimisation, at most changes.version; 0: none since
};

// The store reads the changes and the last optimisation separately. If an optimisation is committed in between, its
// poses belong to a later version than the changes, which are then read again.
absl::StatusOr<GraphUpdate> ReadUpdate(const storage::GraphStore& store, const storage::CallContext& context,
                                       const SiteId& site, const SiteGraph* old) {
  const std::int64_t since = old == nullptr ? 0 : old->graph().version();
  const std::int64_t known_solution = old == nullptr ? 0 : old->solution_version;
  GraphUpdate update;
  do {
    ENFILADE_ASSIGN_OR_RETURN(update.changes, store.ReadChanges(context, site, since));
    const bool unchanged = since != 0 && update.changes.version == since;
    if (unchanged) return update;
    // Optimisations up to `since` have been considered before.
    const std::int64_t considered = update.changes.complete ? 0 : std::max(known_solution, since);
    ENFILADE_ASSIGN_OR_RETURN(update.solution_version, store.FindLastOptimization(context, site, considered));
  } while (update.solution_version > update.changes.version);
  return update;
}

// `ties` if none of their maps was deleted.
std::shared_ptr<const graph::PlanTies> OfMaps(const std::shared_ptr<const graph::PlanTies>& ties,
                                              const std::vector<MapId>& maps) {
  graph::PlanTies kept = *ties;
  kept.KeepMaps(maps);
  return kept.maps.size() == ties->maps.size() ? ties : std::make_shared<const graph::PlanTies>(std::move(kept));
}

// Of the prior maps in use. Those of `old` are not read again.
absl::StatusOr<std::vector<graph::PlanInGraph>> ReadPlans(const storage::GraphStore& store,
                                                          const storage::CallContext& context, const SiteId& site,
                                                          const SiteGraph* old) {
  std::vector<std::string> known;
  if (old != nullptr) {
    for (const graph::PlanInGraph& plan : old->graph().plans()) known.push_back(plan.sha256);
  }
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<storage::StoredPlanTies> stored,
                            store.ReadPlanTies(context, site, known));
  std::vector<graph::PlanInGraph> plans;
  for (const storage::StoredPlanTies& one : stored) {
    graph::PlanInGraph& plan = plans.emplace_back(
        graph::PlanInGraph{.id = one.prior_map, .sha256 = one.sha256, .ties = {}, .level = one.level});
    const auto found = std::find(known.begin(), known.end(), one.sha256);
    if (found != known.end()) {
      // A map that has been taken from the ties does not come back into the same ones.
      plan.ties = OfMaps(old->graph().plans()[static_cast<std::size_t>(found - known.begin())].ties, one.maps);
      continue;
    }
    absl::StatusOr<graph::PlanTies> ties = graph::DecodePlanTies(one.bytes);
    if (!ties.ok()) {  // the graph can do without
      spdlog::error("{} has no influence: {}", NameOf(site, one.prior_map), ties.status().ToString());
      plans.pop_back();
      continue;
    }
    plan.ties = OfMaps(std::make_shared<const graph::PlanTies>(*std::move(ties)), one.maps);
  }
  return plans;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const SiteGraph>> ReadSiteGraph(const storage::GraphStore& store,
                                                               const storage::CallContext& context, const SiteId& site,
                                                               const std::shared_ptr<const SiteGraph>& old) {
  ENFILADE_ASSIGN_OR_RETURN(const GraphUpdate update, ReadUpdate(store, context, site, old.get()));
  const storage::GraphChanges& changes = update.changes;
  if (old != nullptr && changes.version == old->graph().version()) return old;
  graph::SnapshotChanges snapshot_changes = ToSnapshotChanges(changes);
  ENFILADE_ASSIGN_OR_RETURN(snapshot_changes.plans, ReadPlans(store, context, site, old.get()));
  const bool complete = changes.complete || old == nullptr;
  std::int64_t solution_version = complete ? 0 : old->solution_version;
  if (update.solution_version > 0) {
    const graph::SolvedGraph* known = complete || old->solution_version == 0 || old->graph().root() != changes.root
                                          ? nullptr
                                          : old->graph().solution();
    const auto poses =
        store.GetMapPoses(context, site, update.solution_version, known == nullptr ? 0 : old->solution_version);
    if (!poses.ok() && !absl::IsNotFound(poses.status())) return poses.status();
    if (poses.ok()) snapshot_changes.solution = ToSolvedGraph(known, *poses, update.solution_version, changes.root);
    if (snapshot_changes.solution != nullptr) solution_version = update.solution_version;
  }
  const SiteGraph none{graph::GraphSnapshot()};
  const SiteGraph& before = complete ? none : *old;
  ENFILADE_ASSIGN_OR_RETURN(graph::GraphSnapshot snapshot, graph::Apply(before.graph(), snapshot_changes));
  PlacedLinkPoints placed = before.placed.With(before.graph(), snapshot, changes);
  auto graph = std::make_shared<SiteGraph>(std::move(snapshot), std::move(placed));
  const graph::SolvedGraph* solution = graph->graph().solution();
  graph->solution_version = solution != nullptr && solution->root == graph->graph().root() ? solution_version : 0;
  ENFILADE_ASSIGN_OR_RETURN(graph->control_points, store.GetControlPoints(context, site));
  if (!graph->control_points.empty()) {
    auto fit = FitControlPoints(graph->poses, graph->control_points);
    if (fit.ok()) {
      graph->georeference = *std::move(fit);
    } else {
      spdlog::warn("site {}: no georeference: {}", site.value(), fit.status().ToString());
    }
  }
  return std::shared_ptr<const SiteGraph>(std::move(graph));
}

}  // namespace enfilade::server
