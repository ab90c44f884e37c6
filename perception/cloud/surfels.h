// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "perception/cloud/cloud.h"
#include "perception/cloud/nearest_points.h"

namespace enfilade::perception {

// A cloud prepared for registration: each point with the shape of the surface around it.
struct Surfels {
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Matrix3d> covariances;  // regularised to (1, 1, 0.001) along the plane (Segal et al. 2009, III.B)
  std::vector<Eigen::Vector3d> normals;      // unit, of either sign
  std::vector<double> flatness;              // 0 a ball or a line .. 1 a plane
};

// `neighbours`: the number of nearest points per surface fit.
Surfels MakeSurfels(const std::vector<Eigen::Vector3f>& points, const NearestPoints& tree, int neighbours);

}  // namespace enfilade::perception
