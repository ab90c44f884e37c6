// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/graph/graph_optimization.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/solved_graph.h"

namespace enfilade::graph {

// Poses that differ by less count as equal.
constexpr double kMovedDistance = 1e-3;  // m
constexpr double kMovedYaw = 1e-4;       // rad

// A map that two solutions pose differently. Unset: no link points join it to the root.
struct MovedMap {
  MapId map;
  std::optional<PoseWithCovariance> T_world_map_before;
  std::optional<PoseWithCovariance> T_world_map_after;
};

// How much the anchors of a link point disagree in two solutions: chi-squared; 0: it takes no part in that solution.
struct ResidualChange {
  LinkPointId link_point;
  double chi2_before = 0.0;
  double chi2_after = 0.0;
  double gate = 0.0;  // beyond it, it is switched off; 0: it takes part in neither solution
  bool switched_off_before = false;
  bool switched_off_after = false;
};

struct SolutionDifference {
  // Those that one of the solutions does not pose first, then the farthest moved; else by id.
  std::vector<MovedMap> moved;
  // Of the link points asked for and of those that are switched off before or after, by id.
  std::vector<ResidualChange> residuals;
};

// A graph with its optimum (OptimizeGraph), which need not be part of it.
struct GraphWithSolution {
  const GraphSnapshot& graph;
  std::shared_ptr<const SolvedGraph> solution;
};

// What a change of link points does to the optimum. `asked`: the link points whose residuals are wanted. Costs about as
// much as one iteration of the optimisation.
absl::StatusOr<SolutionDifference> CompareSolutions(const GraphWithSolution& before, const GraphWithSolution& after,
                                                    const std::vector<LinkPointId>& asked,
                                                    const GraphOptimizationOptions& options = {});

}  // namespace enfilade::graph
