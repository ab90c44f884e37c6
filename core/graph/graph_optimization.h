// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/solved_graph.h"

namespace enfilade::graph {

struct GraphOptimizationOptions {
  // A link point whose anchors disagree by more than this quantile of chi-squared (3 degrees of freedom for each anchor
  // beyond the first) is switched off. (0, 1).
  double gate_probability = 0.999;
  // Of the robust kernel (dynamic covariance scaling) under which wrong link points are found, in standard deviations.
  double kernel_width = 3.0;
  // Added to each pair's covariance: what nobody measures better, and what keeps exact anchors solvable.
  double position_floor_m = 1e-4;
  double yaw_floor_rad = 1e-5;
  int max_iterations = 100;
  // Of switching off and solving again.
  int max_rounds = 20;
};

// Where the maps lie that the root is joined to: minimises, over T_world_map with the root held at the origin, the
// disagreement of every link point's anchors, each with its full covariance. What is measured is only the anchors'
// local poses, never an earlier world pose, so that solving again adds nothing.
//
// A link point with two anchors is one residual T_i_j = A * B^-1. One with more has its place as a further variable,
// with a residual for each anchor: a residual for each pair would count every anchor more than once.
//
// First all link points but the suspended ones are solved under robust kernels; those beyond the gate are switched off
// and the rest is solved without a kernel. While some of the rest is beyond the gate, the worst is switched off; one
// that was switched off and is within the gate of the final poses is used again, once. Link points that were switched
// off before are judged anew. A link point that alone joins maps is never off: nothing contradicts it.
//
// INVALID_ARGUMENT: options out of range. FAILED_PRECONDITION: the graph has no root. A graph without link points is
// solved: its root lies at the origin.
absl::StatusOr<SolvedGraph> OptimizeGraph(const GraphSnapshot& graph, const GraphOptimizationOptions& options = {});

// The changes that the solution makes to link points' use, for `Apply`: those switched off, and those that no longer
// are. `version` is the one after them.
SnapshotChanges ChangesOf(const GraphSnapshot& graph, SolvedGraph solution, std::int64_t version);

}  // namespace enfilade::graph
