// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <optional>
#include <set>
#include <vector>

#include "core/graph/graph_snapshot.h"
#include "core/graph/joint_graph.h"
#include "core/graph/plans/plan_ties.h"

namespace enfilade::graph {

// A plan in the joint graph.
struct PlanPart {
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  const PlanInGraph* plan = nullptr;
  Pose2 T_world_plan = {};                    // where it was placed
  std::vector<std::size_t> corners = {};      // nodes
  std::vector<std::size_t> edges = {};        // of each sighting; kNone: its map is not part of the graph
  std::vector<std::size_t> strut_edges = {};  // one for each strut, or two for one that was seen
  std::vector<std::size_t> seen_struts = {};  // those of the sightings

  const PlanTies& ties() const { return *plan->ties; }
};

// Adds a node for each corner, which has the turn of the plan around it as its yaw; one for each strut that a map of
// the graph has seen, at its middle, with x along it; an edge for each strut, or two for one with a node; and one for
// each sighting. All are robust. `plan` must outlive the result.
PlanPart AddPlan(const GraphSnapshot& snapshot, const PlanInGraph& plan, const Pose2& T_world_plan, JointGraph& joint);

// Where one corner of a plan, or of a shaft, lies from another, as the plan is drawn: in the plan's frame, m^-2.
// `way`: from the one to the other.
Eigen::Matrix2d CornerInformation(const PlanTies& ties, const Eigen::Vector2d& way);

// Adds a node to the graph, with an id that no map and no link point has. Its index.
std::size_t AddNode(const GraphSnapshot& snapshot, const Pose2& T_world_node, JointGraph& joint);
// Adds a robust edge between two nodes, given by their indices.
void AddEdge(std::size_t from, std::size_t to, const Pose2& T_from_to, const Eigen::Matrix3d& information,
             JointGraph& joint);

// Of each node, whether enabled edges join it to the root.
std::vector<char> JoinedNodes(const JointGraph& joint);

// The edges of sightings that are in doubt: a wall that was seen would be stretched to less than 0.7 or more than 1.4
// of its length, and they are of walls that meet at that end of it which has moved otherwise than the corners around.
// One of them has been taken for another. Walls of less than 2 m may be stretched in any way. Of sightings that count
// only.
std::set<std::size_t> EdgesAroundStretched(const JointGraph& joint, const PlanPart& part);

// Of the pose of a map that only plans join, given that by the solution: with what SLAM bends maps. Unset: it is not
// known well enough.
std::optional<Eigen::Matrix3d> CovarianceByPlan(const Eigen::Matrix3d& solved);

}  // namespace enfilade::graph
