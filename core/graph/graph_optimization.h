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
  // Width of the robust kernel (dynamic covariance scaling) that identifies wrong link points, in standard deviations.
  double kernel_width = 3.0;
  // Added to each pair's covariance: a lower bound of measurement noise that keeps exact anchors solvable.
  double position_floor_m = 1e-4;
  double yaw_floor_rad = 1e-5;
  int max_iterations = 100;
  // Limit of rounds of switching off and solving again.
  int max_rounds = 20;
  // The map of which SolvedGraph::plan_shares is wanted; empty: of none.
  MapId shares_of = {};
};

// Estimates the world poses of all maps connected to the root: minimises, over T_world_map with the root fixed at the
// origin, the disagreement of every link point's anchors with their full covariances. The only measurements are the
// anchors' local poses, never an earlier world pose, so solving again changes nothing.
//
// A link point with two anchors is one residual T_i_j = A * B^-1. One with more anchors adds its own pose as a variable
// and has one residual per anchor: a residual per pair would count every anchor more than once.
//
// First all link points except suspended ones are solved under robust kernels. Those beyond the gate are switched off
// and the rest is solved without a kernel. While a used link point is beyond the gate, the worst one is switched off; a
// switched-off one that is within the gate of the new poses is used again, at most once. Link points switched off
// earlier are judged again. A link point that is the only connection between maps is never switched off: nothing
// contradicts it. A link point with a covariance that no measurement has (ValidateMeasuredCovariance) is switched off
// before anything is solved, with chi2 and gate 0.
//
// Then the graph's floor plans, if it has any, tie maps together: see SolveWithPlans.
//
// INVALID_ARGUMENT: options out of range. FAILED_PRECONDITION: the graph has no root. A graph without link points has
// the trivial solution: its root at the origin.
absl::StatusOr<SolvedGraph> OptimizeGraph(const GraphSnapshot& graph, const GraphOptimizationOptions& options = {});

// The changes of link points' use by the solution, for `Apply`: those newly switched off and those used again.
// `version` is the version after the changes.
SnapshotChanges ChangesOf(const GraphSnapshot& graph, SolvedGraph solution, std::int64_t version);

}  // namespace enfilade::graph
