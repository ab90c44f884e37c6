// SPDX-License-Identifier: Apache-2.0
#include "core/graph/joint_graph.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "core/base/status_macros.h"
#include "core/geometry/covariance.h"
#include "core/graph/paths/pose_chain.h"
#include "core/optimize/edge_error.h"

namespace enfilade::graph {
namespace {

// The inverse covariance of a measured pose, in the frame of PoseGraphEdge's error: that of the measured pose.
Eigen::Matrix3d InformationOf(const PoseWithCovariance& measured, const GraphOptimizationOptions& options) {
  Eigen::Matrix3d covariance = 0.5 * (measured.covariance + measured.covariance.transpose());
  covariance(0, 0) += options.position_floor_m * options.position_floor_m;
  covariance(1, 1) += options.position_floor_m * options.position_floor_m;
  covariance(2, 2) += options.yaw_floor_rad * options.yaw_floor_rad;
  const double c = std::cos(measured.pose.yaw);
  const double s = std::sin(measured.pose.yaw);
  Eigen::Matrix3d to_measured = Eigen::Matrix3d::Identity();
  to_measured.topLeftCorner<2, 2>() << c, s, -s, c;
  const Eigen::Matrix3d information = (to_measured * covariance * to_measured.transpose()).inverse();
  return 0.5 * (information + information.transpose());
}

optimize::PoseGraphEdge Edge(int from, std::int64_t to, const PoseWithCovariance& measured,
                             const GraphOptimizationOptions& options) {
  return {.from = from,
          .to = to,
          .T_from_to = measured.pose,
          .information = InformationOf(measured, options),
          .robust = true,
          .enabled = true};
}

bool IsSolved(const LinkPoint& link_point) {
  return link_point.use != LinkPointUse::kSuspended && !link_point.is_candidate() && !IsUnusable(link_point);
}

// The maps connected to any of those that are reached, breadth first, with their initial poses.
std::vector<PlacedSlot> Reach(const GraphSnapshot& snapshot, std::vector<PlacedSlot> reached) {
  std::vector<char> seen(snapshot.map_slots(), 0);
  for (const auto& [map, T_world_map] : reached) seen[static_cast<std::size_t>(map)] = 1;
  for (std::size_t next = 0; next < reached.size(); ++next) {
    const auto [map, T_world_map] = reached[next];
    for (const int slot : snapshot.map_node(map).link_points) {
      const GraphSnapshot::LinkPointNode& node = snapshot.link_point_node(slot);
      if (!IsSolved(*node.link_point)) continue;
      const Anchor& here = *node.link_point->FindAnchor(snapshot.map_node(map).map->id);
      for (std::size_t i = 0; i < node.maps.size(); ++i) {
        char& known = seen[static_cast<std::size_t>(node.maps[i])];
        if (known != 0) continue;
        known = 1;
        const Anchor& there = node.link_point->anchors[i];
        const PoseWithCovariance* solved = snapshot.FindSolvedPose(there.map);
        reached.emplace_back(node.maps[i], solved != nullptr
                                               ? solved->pose
                                               : T_world_map * here.T_map_place * Inverse(there.T_map_place));
      }
    }
  }
  return reached;
}

void AddTerm(const GraphSnapshot& snapshot, int slot, const GraphOptimizationOptions& options, JointGraph& joint,
             const std::vector<Pose2>& T_world_maps) {
  const GraphSnapshot::LinkPointNode& node = snapshot.link_point_node(slot);
  const std::vector<Anchor>& anchors = node.link_point->anchors;
  JointTerm term{.link_point = slot, .edges = {}, .degrees_of_freedom = 3 * (static_cast<int>(anchors.size()) - 1)};
  const auto add = [&joint, &term](optimize::PoseGraphEdge edge) {
    term.edges.push_back(joint.graph.edges.size());
    joint.graph.edges.push_back(std::move(edge));
  };
  if (anchors.size() == 2) {
    add(Edge(node.maps[0], node.maps[1], TransformAcross(anchors[0], anchors[1]), options));
  } else {
    const std::int64_t place = static_cast<std::int64_t>(snapshot.map_slots()) + slot;
    const Pose2& T_world_map = T_world_maps[static_cast<std::size_t>(node.maps[0])];
    joint.graph.nodes.push_back({.id = place, .T_world_node = T_world_map * anchors[0].T_map_place});
    for (std::size_t i = 0; i < anchors.size(); ++i) {
      add(Edge(node.maps[i], place, {anchors[i].T_map_place, anchors[i].covariance}, options));
    }
  }
  joint.terms.push_back(std::move(term));
}

}  // namespace

bool IsUnusable(const LinkPoint& link_point) {
  return std::any_of(link_point.anchors.begin(), link_point.anchors.end(),
                     [](const Anchor& anchor) { return !ValidateMeasuredCovariance(anchor.covariance).ok(); });
}

JointGraph BuildJointGraph(const GraphSnapshot& snapshot, int root, const GraphOptimizationOptions& options) {
  return BuildJointGraph(snapshot, {{root, Pose2()}}, options);
}

JointGraph BuildJointGraph(const GraphSnapshot& snapshot, const std::vector<PlacedSlot>& starts,
                           const GraphOptimizationOptions& options) {
  JointGraph joint;
  std::vector<char> reached(snapshot.map_slots(), 0);
  std::vector<Pose2> T_world_maps(snapshot.map_slots());
  for (const auto& [map, T_world_map] : Reach(snapshot, starts)) {
    reached[static_cast<std::size_t>(map)] = 1;
    T_world_maps[static_cast<std::size_t>(map)] = T_world_map;
    joint.graph.nodes.push_back({.id = map, .T_world_node = T_world_map});
  }
  joint.maps = joint.graph.nodes.size();
  for (const MapInGraph* map : snapshot.ListMaps()) {
    if (reached[static_cast<std::size_t>(snapshot.MapSlot(map->id))] == 0) joint.disconnected.push_back(map->id);
  }
  for (const LinkPoint* link_point : snapshot.ListLinkPoints()) {
    const int slot = snapshot.LinkPointSlot(link_point->id);
    const int map = snapshot.link_point_node(slot).maps.front();
    if (!IsSolved(*link_point) || reached[static_cast<std::size_t>(map)] == 0) continue;
    AddTerm(snapshot, slot, options, joint, T_world_maps);
  }
  for (std::size_t i = 0; i < joint.graph.nodes.size(); ++i) joint.node_of[joint.graph.nodes[i].id] = i;
  return joint;
}

absl::StatusOr<optimize::SolveReport> SolveJointGraph(const GraphOptimizationOptions& options,
                                                      const optimize::RobustKernel& kernel,
                                                      optimize::Initialisation initialisation, JointGraph& joint) {
  optimize::SolveOptions solve{.initialisation = initialisation,
                               .kernel = kernel,
                               .max_iterations = options.max_iterations,
                               .fixed = {joint.graph.nodes.front().id}};
  if (kernel.type == optimize::RobustKernel::Type::kNone) {
    for (std::size_t i = 0; i < joint.maps; ++i) solve.covariance_of.push_back(joint.graph.nodes[i].id);
  }
  return optimize::SolvePoseGraph(solve, joint.graph);
}

void SetEnabled(JointGraph& joint, const JointTerm& term, bool enabled) {
  for (const std::size_t edge : term.edges) joint.graph.edges[edge].enabled = enabled;
}

absl::StatusOr<double> Disagreement(const JointGraph& joint, const std::vector<optimize::PoseGraphNode>& nodes,
                                    const JointTerm& term) {
  const auto node = [&joint, &nodes](std::int64_t id) { return nodes[joint.node_of.at(id)]; };
  if (term.edges.size() == 1) {
    const optimize::PoseGraphEdge& edge = joint.graph.edges[term.edges.front()];
    const Eigen::Vector3d error = optimize::EdgeError(node(edge.from).T_world_node, node(edge.to).T_world_node,
                                                      optimize::EdgeMeasurement(edge.T_from_to));
    return error.dot(edge.information * error);
  }
  optimize::PoseGraph star;
  optimize::SolveOptions options{.initialisation = optimize::Initialisation::kNone};
  for (const std::size_t index : term.edges) {
    optimize::PoseGraphEdge edge = joint.graph.edges[index];
    edge.enabled = true;
    star.nodes.push_back(node(edge.from));
    options.fixed.push_back(edge.from);
    if (star.edges.empty()) {
      star.nodes.push_back({.id = edge.to, .T_world_node = node(edge.from).T_world_node * edge.T_from_to});
    }
    star.edges.push_back(std::move(edge));
  }
  ENFILADE_ASSIGN_OR_RETURN(const optimize::SolveReport report, optimize::SolvePoseGraph(options, star));
  return report.final_chi2;
}

}  // namespace enfilade::graph
