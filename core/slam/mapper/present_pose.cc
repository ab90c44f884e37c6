// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/present_pose.h"

#include <Eigen/Dense>

#include "core/slam/loops/slam_graph.h"
#include "core/slam/mapper/policies.h"
#include "core/slam/state/mapper_state.h"

namespace enfilade::slam {
namespace {

PoseWithCovariance Measured(const Pose2& pose, const Eigen::Matrix3d& information, double factor) {
  const Eigen::Matrix3d covariance = factor * information.inverse();
  return {pose, 0.5 * (covariance + covariance.transpose())};
}

bool IsActive(const MapperState& state, std::int64_t submap) { return state.active && state.active->id == submap; }

const std::vector<SubmapNode>& NodesOf(const MapperState& state, std::int64_t submap) {
  return IsActive(state, submap) ? state.active->content.nodes : state.finished.at(submap).nodes;
}

const Pose2& PoseOf(const MapperState& state, std::int64_t submap) {
  return IsActive(state, submap) ? state.active->T_map_submap : state.finished.at(submap).T_map_submap;
}

struct PlacedSubmap {
  std::int64_t id = 0;
  PoseWithCovariance T_map_submap;
};

// The submap of the last keyframe with a covariance from the graph; the first submap if there is none.
PlacedSubmap LastSolvedSubmap(const MapperState& state) {
  const auto solved = state.nodes.find(state.nodes_at_solve - 1);
  if (solved == state.nodes.end() || solved->second.covariance.isZero()) return {};
  const SlamNode& node = solved->second;
  for (const SubmapNode& measured : NodesOf(state, node.submap)) {
    if (measured.carried || measured.node != node.id) continue;
    // Composed backwards from the keyframe without the measurement's own error: the keyframe's covariance includes it.
    const PoseWithCovariance T_node_submap{Inverse(measured.T_submap_node), Eigen::Matrix3d::Zero()};
    return {node.submap, Compose({node.T_map_node, node.covariance}, T_node_submap)};
  }
  return {};
}

}  // namespace

std::optional<PresentPose> FindPresentPose(const MapperState& state, const QualityOptions& options) {
  if (!state.track) return std::nullopt;
  const std::int64_t now = state.last_submap();
  const double factor = VarianceFactor(state.errors);
  PlacedSubmap submap = LastSolvedSubmap(state);
  for (; submap.id < now; ++submap.id) {
    const std::optional<NextSubmap>& next = state.finished.at(submap.id).next;
    const double tie = IsMeasured(state, submap.id, *next) ? factor : 1.0;
    submap.T_map_submap = Compose(submap.T_map_submap, Measured(next->T_submap_next, next->information, tie));
  }
  const SubmapNode& last = NodesOf(state, now).back();
  PresentPose present;
  present.time = state.track->time;
  const Pose2 T_last_robot = Between(last.T_submap_node, state.track->T_submap_robot);
  present.T_map_robot = Compose({PoseOf(state, now), submap.T_map_submap.covariance},
                                Measured(state.track->T_submap_robot, last.information, factor));
  // As in the trajectory: relative to the keyframe, which loop closures may have moved in its submap.
  present.T_map_robot.pose = state.nodes.at(last.node).T_map_node * T_last_robot;
  present.lost = IsLost(state.track->quality, options) || state.adrift_since.has_value();
  return present;
}

}  // namespace enfilade::slam
