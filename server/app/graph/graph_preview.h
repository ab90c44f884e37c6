// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/solve/compare_solutions.h"
#include "core/graph/solved_graph.h"
#include "server/app/graph/site_graph.h"
#include "storage/graph/link_point_store.h"

namespace enfilade::server {

// The graph as LinkPointStore::Change would leave it, at the same version. Errors as there.
absl::StatusOr<graph::GraphSnapshot> WithChanges(const SiteId& site, const SiteGraph& graph,
                                                 const std::vector<storage::LinkPointChange>& changes);

// What changes would do to the optimum of a graph.
struct GraphPreview {
  std::shared_ptr<const graph::SolvedGraph> before;
  std::shared_ptr<const graph::SolvedGraph> after;
  graph::SolutionDifference difference;  // with the residuals of the link points that change
};

// Nothing is stored. `before`: the optimum of `graph`. Takes about as long as an optimisation. Errors as WithChanges.
absl::StatusOr<GraphPreview> PreviewChanges(const SiteId& site, const SiteGraph& graph,
                                            std::shared_ptr<const graph::SolvedGraph> before,
                                            const std::vector<storage::LinkPointChange>& changes);

}  // namespace enfilade::server
