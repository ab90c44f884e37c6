// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/slam/matching/likelihood_field.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// A Gaussian prior on the pose.
struct PosePrior {
  Pose2 pose;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  // of (x, y, yaw) of `pose`
};

// The result of matching one scan to one field.
struct MatchResult {
  Pose2 T_submap_robot;
  // Of (x, y, yaw) of T_submap_robot, from the scan alone, without the prior: nearly singular in a corridor.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double matched_share = 0.0;  // share of the points within the options' matched distance, 0..1
  // m: 68 % of those points are at most this far from their wall, which is the standard deviation if errors are normal.
  double residual = 0.0;
  int iterations = 0;
  bool converged = false;
};

// The cost of a pose:
//   sum_i w rho(r_i^2) + (pose - prior)' prior.information (pose - prior),   r_i = d_i / sigma,
// with d_i the field's distance at point i, rho(s) = k^2 log(1 + s / k^2) Cauchy's kernel of width k and
// w = min(1, effective_beams / number of points). Where the normal n_i of the surface at the point is known, only the
// part of the way to the wall that is along n_i counts (point-to-line, Censi 2008: "An ICP variant using a
// point-to-line metric"), and less the larger the part t_i across it: the point's weight is divided by 1 + (t_i / (k
// sigma))^2. A hit on a part of a wall that the field does not have yet is nearest to the end of the part that it has;
// without normals it would pull the scan there, along the wall.
struct MatchCost {
  double value = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  // half the derivative of `value`
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();   // of half of `value`, Gauss-Newton approximation
};

MatchCost EvaluateMatch(const LikelihoodField& field, const std::vector<Eigen::Vector2d>& points, const Pose2& pose,
                        const PosePrior& prior, const FieldMatchOptions& options,
                        const std::vector<Eigen::Vector2d>& normals = {});

// Levenberg-Marquardt from `guess`. `points` are in the robot's frame, as are their `normals` (SurfaceNormals), of
// which there may be none.
MatchResult MatchToField(const LikelihoodField& field, const std::vector<Eigen::Vector2d>& points, const Pose2& guess,
                         const PosePrior& prior, const FieldMatchOptions& options,
                         const std::vector<Eigen::Vector2d>& normals = {});

}  // namespace enfilade::slam
