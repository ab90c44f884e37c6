// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "perception/cloud/registration.h"
#include "perception/cloud/surfels.h"

namespace enfilade::perception {

struct AlignOptions {
  RegistrationMethod method = RegistrationMethod::kGicp;
  double first_distance = 2.0;  // m, of corresponding points at the start
  double last_distance = 0.6;   // m, at the end
  int max_iterations = 60;
};

struct Alignment {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  bool converged = false;
  int iterations = 0;
  int correspondences = 0;                                                   // at the end
  double weighted_residual = 0.0;                                            // sum of r' W r at the end
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();  // of (translation, rotation) at the end
};

// Gauss-Newton with correspondences searched again in each step and weighted by their distance (Geman-McClure). The
// allowed distance shrinks from step to step.
Alignment Align(const Surfels& source, const Surfels& target, const NearestPoints& target_tree,
                const Eigen::Isometry3d& T_target_source_guess, const AlignOptions& options);

}  // namespace enfilade::perception
