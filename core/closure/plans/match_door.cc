// SPDX-License-Identifier: Apache-2.0
#include "core/closure/plans/match_door.h"

#include <cmath>

#include "core/base/status_macros.h"
#include "core/closure/pose_gate.h"
#include "core/graph/graph_optimization.h"
#include "core/sensor/laser_scan.h"
#include "core/slam/slam_options.h"
#include "fmt/format.h"

namespace enfilade::closure {
namespace {

constexpr double kBehindOpening = 0.5;   // m: the wall's other face and the frame are nearer
constexpr double kOpeningMargin = 0.05;  // m

// It fits well at another place than the one that is predicted.
bool IsElsewhere(const ScanLocation& location) { return !location.accepted && location.matched_share > 0.0; }

// T_there_door of the door that `here` has, by the door that `there` has in `here`.
PoseWithCovariance Reversed(const PoseWithCovariance& T_here_theirs, const DoorInMaps& door) {
  const PoseWithCovariance T_theirs_ours =
      Compose(Inverse(T_here_theirs), PoseWithCovariance{door.T_here_door, Eigen::Matrix3d::Zero()});
  return Compose(PoseWithCovariance{door.T_there_door, Eigen::Matrix3d::Zero()}, T_theirs_ours);
}

}  // namespace

absl::StatusOr<std::optional<PoseWithCovariance>> PredictBetween(const graph::GraphSnapshot& graph, const MapId& there,
                                                                 const MapId& here) {
  ENFILADE_ASSIGN_OR_RETURN(const graph::GraphSnapshot held,
                            graph::Apply(graph, {.version = graph.version(), .root = there}));
  ENFILADE_ASSIGN_OR_RETURN(const graph::SolvedGraph solution, graph::OptimizeGraph(held));
  const auto found = solution.map_poses.find(here);
  if (found == solution.map_poses.end()) return std::nullopt;
  return found->second;
}

std::vector<Eigen::Vector2d> PointsThroughDoor(const std::vector<PlacedScan>& scans, const Pose2& T_map_door,
                                               double width) {
  const double max_range = slam::SlamOptions().max_range;
  const double half = 0.5 * width - kOpeningMargin;
  std::vector<Eigen::Vector2d> points;
  for (const PlacedScan& one : scans) {
    const Pose2 T_door_robot = Between(T_map_door, one.T_map_robot.pose);
    const Eigen::Vector2d laser = (T_door_robot * one.scan.T_robot_laser).translation();
    if (laser.x() >= 0.0) continue;  // it is through
    for (const Eigen::Vector2d& point : sensor::HitPoints(one.scan, max_range)) {
      const Eigen::Vector2d hit = T_door_robot * point;
      if (hit.x() < kBehindOpening) continue;
      const double share = laser.x() / (laser.x() - hit.x());  // of the beam, to the door's plane
      if (std::abs(laser.y() + share * (hit.y() - laser.y())) <= half) points.push_back(hit);
    }
  }
  return points;
}

DoorMatch JudgeDoorScans(const ScanLocation& forth, const ScanLocation& back, const DoorInMaps& door,
                         const DoorClosureOptions& options) {
  DoorMatch match;
  match.reason = fmt::format("through it, one way: {}; the other way: {}", forth.reason, back.reason);
  match.contradicted = IsElsewhere(forth) || IsElsewhere(back);
  if (match.contradicted || (!forth.accepted && !back.accepted)) return match;
  if (!back.accepted) {
    match.T_there_door = forth.T_map_robot;
    return match;
  }
  const PoseWithCovariance reversed = Reversed(back.T_map_robot, door);
  match.T_there_door = reversed;
  if (!forth.accepted) return match;
  const double chi2 = PoseChiSquared(forth.T_map_robot, reversed, options.pose_sigma, options.pose_yaw_sigma);
  match.reason += fmt::format("; both have the same pose with chi-squared {:.1f}", chi2);
  match.contradicted = chi2 > Gate(options);
  if (match.contradicted) {
    match.T_there_door.reset();
  } else if (forth.T_map_robot.covariance.trace() <= reversed.covariance.trace()) {
    match.T_there_door = forth.T_map_robot;
  }
  return match;
}

}  // namespace enfilade::closure
