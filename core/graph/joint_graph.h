// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "absl/status/statusor.h"
#include "core/graph/graph_optimization.h"
#include "core/graph/graph_snapshot.h"
#include "core/optimize/pose_graph.h"

namespace enfilade::graph {

// A link point in the joint graph.
struct JointTerm {
  int link_point = 0;  // slot
  std::vector<std::size_t> edges = {};
  int degrees_of_freedom = 3;  // of its disagreement: 3 for each anchor beyond the first
};

// The maps that the root is joined to and the link points that join them, as a pose graph: a map's node has its slot
// for an id, the place of a link point with three or more anchors the number of map slots plus its own slot.
struct JointGraph {
  optimize::PoseGraph graph;  // its first nodes are the maps; the first is the root
  std::size_t maps = 0;
  std::unordered_map<std::int64_t, std::size_t> node_of;  // by id: position in graph.nodes
  std::vector<JointTerm> terms;
  std::vector<MapId> disconnected;  // by id
};

// Begins at the solution's poses, and where there are none at those of the chain of the fewest link points. Suspended
// link points and candidates are not in it; those switched off are.
JointGraph BuildJointGraph(const GraphSnapshot& snapshot, int root, const GraphOptimizationOptions& options);

void SetEnabled(JointGraph& joint, const JointTerm& term, bool enabled);

// By how much the anchors of the link point disagree where the maps have the poses of `nodes` (joint.graph.nodes, moved
// or not), its place put where they disagree least: chi-squared with term.degrees_of_freedom.
absl::StatusOr<double> Disagreement(const JointGraph& joint, const std::vector<optimize::PoseGraphNode>& nodes,
                                    const JointTerm& term);

}  // namespace enfilade::graph
