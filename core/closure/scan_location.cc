// SPDX-License-Identifier: Apache-2.0
#include "core/closure/scan_location.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/closure/pose_gate.h"
#include "core/graph/search_radius.h"
#include "core/slam/loops/loop_matching.h"
#include "core/slam/matching/field_pyramid.h"
#include "core/slam/submaps/robot_rays.h"
#include "fmt/format.h"

namespace enfilade::closure {
namespace {

constexpr double kBeforeDoor = 0.3;  // m: walls and frames around the door belong to both sides
constexpr double kHalfDoor = 1.0;    // m
constexpr double kDoorway = 0.5;  // m around the middle of a door, including the depth of its frame and a pose's error
constexpr double kSigmas = 3.0;
// In a narrower window a place that repeats would look unique.
constexpr double kMinHalfWidth = 3.0;  // m
constexpr double kMinHalfAngle = 0.3;  // rad

slam::SubmapGrid GridOf(const std::vector<PlacedScan>& scans) {
  const slam::SlamOptions slam;
  slam::SubmapGrid grid(slam.resolution, slam.occupancy);
  const grid::ScanRayOptions rays{.max_range = slam.max_range};
  // A scan that does not fit into the grid (its pose is far off) shows nothing of this place.
  for (const PlacedScan& one : scans) grid.Insert(one.T_map_robot.pose, slam::RobotRays(one.scan, rays)).IgnoreError();
  return grid;
}

const PoseWithCovariance& Nearest(const std::vector<PoseWithCovariance>& viewpoints, const Pose2& pose) {
  return *std::min_element(viewpoints.begin(), viewpoints.end(), [&](const auto& a, const auto& b) {
    return Between(pose, a.pose).translation().norm() < Between(pose, b.pose).translation().norm();
  });
}

ScanLocation Refused(std::string reason) {
  ScanLocation refused;
  refused.reason = std::move(reason);
  return refused;
}

// Of the 95 % ellipse, m.
double RadiusOf(const PoseWithCovariance& pose) { return graph::ErrorEllipse95(pose.covariance).semi_major_m; }
double YawSigmaOf(const PoseWithCovariance& pose) { return std::sqrt(std::max(pose.covariance(2, 2), 0.0)); }

}  // namespace

std::vector<Eigen::Vector2d> PointsBehindDoor(const std::vector<PlacedScan>& scans, const Pose2& T_map_door,
                                              const Pose2& T_map_robot) {
  const double max_range = slam::SlamOptions().max_range;
  std::vector<Eigen::Vector2d> points;
  for (const PlacedScan& one : scans) {
    const Pose2 T_door_then = Between(T_map_door, one.T_map_robot.pose);
    const Pose2 T_now_then = Between(T_map_robot, one.T_map_robot.pose);
    for (const Eigen::Vector2d& point : sensor::HitPoints(one.scan, max_range)) {
      if ((T_door_then * point).x() >= -kBeforeDoor) points.push_back(T_now_then * point);
    }
  }
  return points;
}

std::vector<PlacedScan> RemoveHitsThroughDoors(std::vector<PlacedScan> scans, const std::vector<Pose2>& T_map_doors) {
  const auto laser_of = [](const PlacedScan& one) { return one.T_map_robot.pose * one.scan.T_robot_laser; };
  std::erase_if(scans, [&](const PlacedScan& one) {
    return std::any_of(T_map_doors.begin(), T_map_doors.end(), [&](const Pose2& T_map_door) {
      return Between(T_map_door, laser_of(one)).translation().norm() < kDoorway;
    });
  });
  for (PlacedScan& one : scans) {
    sensor::LaserScan& scan = one.scan;
    const Pose2 T_map_laser = laser_of(one);
    for (const Pose2& T_map_door : T_map_doors) {
      const Pose2 T_door_laser = Between(T_map_door, T_map_laser);
      for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
        if (sensor::ClassifyBeam(scan, scan.ranges[i]) != sensor::BeamKind::kHit) continue;
        const double angle = T_door_laser.yaw + scan.angle(i);
        const double to_plane = -T_door_laser.x / std::cos(angle);  // along the beam
        if (!(to_plane > 0.0 && to_plane < scan.ranges[i])) continue;
        if (std::abs(T_door_laser.y + to_plane * std::sin(angle)) > kHalfDoor) continue;
        scan.ranges[i] = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
  return scans;
}

SeenGround::SeenGround(const std::vector<PlacedScan>& scans) : submap(GridOf(scans), slam::SlamOptions().pyramid) {
  for (const PlacedScan& one : scans) viewpoints.push_back(one.T_map_robot);
}

std::size_t SeenGround::bytes() const {
  return viewpoints.size() * sizeof(PoseWithCovariance) + submap.grid.bytes() + submap.pyramid.bytes();
}

bool IsSureEnoughForScans(const PoseWithCovariance& predicted, const DoorClosureOptions& options) {
  return RadiusOf(predicted) <= options.alike_distance && YawSigmaOf(predicted) <= options.sure_yaw;
}

ScanLocation LocateByScans(const SeenGround* seen, const std::vector<Eigen::Vector2d>& points,
                           const PoseWithCovariance& predicted, const DoorClosureOptions& options) {
  const double radius = RadiusOf(predicted);
  const double yaw_sigma = YawSigmaOf(predicted);
  if (!IsSureEnoughForScans(predicted, options)) {
    return Refused(
        fmt::format("the graph is not sure enough of where the robot is: {:.1f} m, {:.2f} rad", radius, yaw_sigma));
  }
  if (seen == nullptr || seen->viewpoints.empty()) return Refused("no robot has seen it from inside yet");
  const slam::SlamOptions slam;
  slam::LoopCandidate window;
  window.half_width = std::max(kSigmas / std::sqrt(graph::kChiSquared2Dof95) * radius, kMinHalfWidth);
  window.half_angle = std::max(kSigmas * yaw_sigma, kMinHalfAngle);
  window.is_entry = true;
  const slam::LoopMatch match = slam::MatchLoop(seen->submap, points, predicted.pose, window, slam);
  if (!match.accepted) return Refused(match.reason);
  ScanLocation location;
  location.matched_share = match.score;
  location.T_map_robot = {match.T_submap_node, match.information.inverse()};
  location.T_map_robot.covariance += Nearest(seen->viewpoints, match.T_submap_node).covariance;
  const double chi2 = PoseChiSquared(predicted, location.T_map_robot, options.pose_sigma, options.pose_yaw_sigma);
  const double off = (match.T_submap_node.translation() - predicted.pose.translation()).norm();
  location.reason = fmt::format(
      "{:.0f} % of what the robot's scans show lies on walls of the map, {:.1f} m from where the graph has it to "
      "{:.1f} m, chi-squared {:.1f}",
      100.0 * match.score, off, radius, chi2);
  location.accepted =
      match.score >= options.locate_min_share && chi2 <= Gate(options) && off + radius <= options.alike_distance;
  return location;
}

}  // namespace enfilade::closure
