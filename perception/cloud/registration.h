// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "perception/cloud/cloud.h"

namespace enfilade::perception {

enum class RegistrationMethod {
  kIcp,   // point to point (Besl, McKay 1992)
  kGicp,  // plane to plane (Segal, Haehnel, Thrun 2009)
};

struct RegistrationOptions {
  RegistrationMethod method = RegistrationMethod::kGicp;
  double voxel = 0.2;          // m, both clouds are thinned to it
  double coarse_factor = 3.0;  // the first stage works on voxels so many times larger
  double max_distance = 2.0;   // m, of corresponding points in the first stage; it shrinks to 3 voxels
  int max_iterations = 60;     // of each stage
  int neighbours = 12;         // that a surface is fitted to
  bool try_turned = true;      // also start from the guess turned by 180 degrees about the source's z axis
  // rad: the first stage starts with each of these added to the yaw; from one start it finds 15 degrees.
  std::vector<double> yaw_offsets = {0.0, 0.4, -0.4};
  // A point is an inlier if the other cloud's nearest is within this distance (m) and, where both lie on surfaces, a
  // third of it off the surface and facing the same way within the angle (rad).
  double inlier_distance = 0.3;
  double inlier_angle = 0.6;
  double min_inlier_share = 0.67;  // below it the clouds are not of one place
  double max_fitness = 0.5;        // m^2, the original's icp_fitness_score_thr
  double max_tilt = 0.2;           // rad, roll and pitch of the result: robots stand upright
};

// INVALID_ARGUMENT naming the option that is out of range.
absl::Status Validate(const RegistrationOptions& options);

// What came out, and whether it may be trusted.
struct Registration {
  // Accepted: converged, inlier share, fitness and tilt within the options.
  bool accepted = false;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  bool converged = false;
  bool turned = false;  // found from the turned start
  int iterations = 0;
  // Mean squared distance of source points to the target's nearest, of those nearer than max_distance, m^2; infinity
  // where there are none.
  double fitness = 0.0;
  // Share of one cloud's points, floor and ceiling apart, that have their like in the other, of those inside the
  // other's bounding box; the smaller of both directions.
  double inlier_share = 0.0;
  double overlap = 0.0;  // share of one cloud's points inside the other's bounding box; the larger of both directions
  // Of (x, y, z, roll, pitch, yaw), small rotations about the target's axes at the source's origin: residual variance
  // times the inverse of the normal equations; neighbours' residuals are taken as one measurement. Large where the
  // scene leaves a direction open, such as along a bare corridor.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::string reason;
};

// Finds the pose of `source` in `target`'s frame from a first guess, coarse to fine, from the guess and from the turned
// guess; the best is taken. A poor result is a result (accepted = false), also for clouds of too few points.
// INVALID_ARGUMENT: options, a guess that is not finite, points too far away. Deterministic, thread-safe.
absl::StatusOr<Registration> RegisterClouds(const Cloud& source, const Cloud& target,
                                            const Eigen::Isometry3d& T_target_source_guess,
                                            const RegistrationOptions& options = {});

// x, y, yaw of a registration, with its covariance.
PoseWithCovariance PlanarPose(const Registration& registration);

// Where the robot is in an old map: `T_map_target` is where the robot stood in that map when it took the target cloud,
// in its own frame; the registration's source is the cloud around the robot now.
PoseWithCovariance RobotInMap(const PoseWithCovariance& T_map_target, const Registration& registration);

}  // namespace enfilade::perception
