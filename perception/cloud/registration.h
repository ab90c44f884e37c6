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
  double voxel = 0.2;          // m, side of the voxels to which both clouds are thinned
  double coarse_factor = 3.0;  // the first stage uses voxels larger by this factor
  double max_distance = 2.0;   // m, between corresponding points in the first stage; shrinks to 3 voxels
  int max_iterations = 60;     // per stage
  int neighbours = 12;         // points per surface fit
  bool try_turned = true;      // also start from the guess turned by 180 degrees about the source's z axis
  // Yaw offsets of the first stage's starts, rad; each start corrects errors of up to about 15 degrees.
  std::vector<double> yaw_offsets = {0.0, 0.4, -0.4};
  // A point is an inlier if the other cloud's nearest point is within this distance (m) and, if both lie on surfaces,
  // the distance off the surface is at most a third of it and the normals agree within the angle (rad).
  double inlier_distance = 0.3;
  double inlier_angle = 0.6;
  double min_inlier_share = 0.67;  // below it the clouds show different places
  double max_fitness = 0.5;        // m^2, map_manager's icp_fitness_score_thr
  double max_tilt = 0.2;           // rad, roll and pitch of the result: robots stand upright
};

// INVALID_ARGUMENT naming the option that is out of range.
absl::Status Validate(const RegistrationOptions& options);

// The result of a registration and its quality.
struct Registration {
  // Accepted: converged, inlier share, fitness and tilt within the options.
  bool accepted = false;
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  bool converged = false;
  bool turned = false;  // found from the turned start
  int iterations = 0;
  // Mean squared distance of source points to their nearest target points, of those within max_distance, m^2; infinity
  // if there are none.
  double fitness = 0.0;
  // Share of inliers among one cloud's points inside the other's bounding box, without floor and ceiling; the smaller
  // of both directions.
  double inlier_share = 0.0;
  double overlap = 0.0;  // share of one cloud's points inside the other's bounding box; the larger of both directions
  // Of (x, y, z, roll, pitch, yaw), small rotations about the target's axes at the source's origin: residual variance
  // times the inverse of the normal equations; neighbours' residuals count as one measurement. Large if the scene
  // leaves a direction unconstrained, such as along a bare corridor.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::string reason;
};

// Finds the pose of `source` in `target`'s frame from an initial guess and from that guess turned, coarse to fine, and
// returns the better result. A poor result is not an error (accepted = false), even for clouds of too few points.
// INVALID_ARGUMENT: options, a guess that is not finite, points too far away. Deterministic, thread-safe.
absl::StatusOr<Registration> RegisterClouds(const Cloud& source, const Cloud& target,
                                            const Eigen::Isometry3d& T_target_source_guess,
                                            const RegistrationOptions& options = {});

// x, y, yaw of a registration, with its covariance.
PoseWithCovariance PlanarPose(const Registration& registration);

// The robot's pose in an existing map. `T_map_target` is the pose in that map from which the target cloud was taken, in
// the robot's frame then; the source is the cloud around the robot now.
PoseWithCovariance RobotInMap(const PoseWithCovariance& T_map_target, const Registration& registration);

}  // namespace enfilade::perception
