// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/graph/graph_optimization.h"
#include "core/graph/graph_snapshot.h"
#include "core/optimize/pose_graph.h"
#include "core/optimize/solve_pose_graph.h"

namespace enfilade::graph {

// A link point in the joint graph.
struct JointTerm {
  int link_point = 0;  // slot
  std::vector<std::size_t> edges = {};
  int degrees_of_freedom = 3;  // of its disagreement: 3 for each anchor beyond the first
};

// A map with its place, T_world_map.
using PlacedSlot = std::pair<int, Pose2>;

// The maps connected to the root and the link points between them, as a pose graph. The id of a map's node is its slot;
// the id of the place of a link point with three or more anchors is the number of map slots plus its own slot.
struct JointGraph {
  optimize::PoseGraph graph;  // its first nodes are the maps; the first is the root
  std::size_t maps = 0;
  std::unordered_map<std::int64_t, std::size_t> node_of;  // by id: position in graph.nodes
  std::vector<JointTerm> terms;
  std::vector<MapId> disconnected;  // by id
};

// Whether an anchor's covariance cannot be solved with: link points are checked when they are stored, but were not
// always.
bool IsUnusable(const LinkPoint& link_point);

// Initial poses are the solution's, or, for maps that it lacks, those of the chain with the fewest link points.
// Includes switched-off link points, but not suspended, unusable ones and candidates.
JointGraph BuildJointGraph(const GraphSnapshot& snapshot, int root, const GraphOptimizationOptions& options);
// The same of the maps connected to any of `starts`, the first of which is the root: these are the first nodes, and
// keep their places.
JointGraph BuildJointGraph(const GraphSnapshot& snapshot, const std::vector<PlacedSlot>& starts,
                           const GraphOptimizationOptions& options);

// Moves the nodes to the optimum, with the root held. Without a kernel, with the covariances of the maps, in their
// order.
absl::StatusOr<optimize::SolveReport> SolveJointGraph(const GraphOptimizationOptions& options,
                                                      const optimize::RobustKernel& kernel,
                                                      optimize::Initialisation initialisation, JointGraph& joint);

void SetEnabled(JointGraph& joint, const JointTerm& term, bool enabled);

// The disagreement of the link point's anchors if the maps have the poses of `nodes` (joint.graph.nodes, possibly
// moved) and its place is optimal: chi-squared with term.degrees_of_freedom.
absl::StatusOr<double> Disagreement(const JointGraph& joint, const std::vector<optimize::PoseGraphNode>& nodes,
                                    const JointTerm& term);

}  // namespace enfilade::graph
