// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/slam/matching/likelihood_field.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// What is known of a pose before a scan is matched.
struct PosePrior {
  Pose2 pose;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  // of (x, y, yaw) of `pose`
};

// One scan matched to one field, and whether to trust it.
struct MatchResult {
  Pose2 T_submap_robot;
  // Of (x, y, yaw) of T_submap_robot, by the scan alone, without the prior: nearly singular in a corridor.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double matched_share = 0.0;  // of the points within the options' matched distance, 0..1
  double rms = 0.0;            // m, of the matched points' distances
  int iterations = 0;
  bool converged = false;
};

// The cost of a pose: sum_i w rho(r_i^2) + (pose - prior)' prior.information (pose - prior), with
// r_i = d_i / sigma the field's distance at point i, rho Cauchy's kernel.
struct MatchCost {
  double value = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  // half the derivative of `value`
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();   // Gauss-Newton's, of half of `value`
};

MatchCost EvaluateMatch(const LikelihoodField& field, const std::vector<Eigen::Vector2d>& points, const Pose2& pose,
                        const PosePrior& prior, const FieldMatchOptions& options);

// Levenberg-Marquardt from `guess`. `points` are in the robot's frame.
MatchResult MatchToField(const LikelihoodField& field, const std::vector<Eigen::Vector2d>& points, const Pose2& guess,
                         const PosePrior& prior, const FieldMatchOptions& options);

}  // namespace enfilade::slam
