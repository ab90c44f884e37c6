// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/optimize/edge_error.h"
#include "core/optimize/pose_graph.h"

namespace enfilade::optimize {

// An enabled edge; its nodes by their positions in IndexedGraph.
struct IndexedEdge {
  int from = 0;
  int to = 0;
  bool robust = true;
  EdgeMeasurement measurement;
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
};

// One connected component of a pose graph, validated, with contiguous indices.
struct IndexedGraph {
  std::vector<int> sources;  // per node: position in PoseGraph::nodes
  std::vector<Pose2> poses;
  std::vector<char> held;  // per node; at least one is true
  std::vector<IndexedEdge> edges;
};

// The components in the order of their first nodes. `fixed`: ids of the nodes to hold; a component without any has its
// first node held. Same errors as SolvePoseGraph.
absl::StatusOr<std::vector<IndexedGraph>> IndexComponents(const PoseGraph& graph,
                                                          const std::vector<std::int64_t>& fixed);

}  // namespace enfilade::optimize
