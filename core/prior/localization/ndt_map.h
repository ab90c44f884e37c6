// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace enfilade::prior {

// The points of one cell of a lattice as a normal distribution.
struct NdtCell {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();        // m
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // m^2, of a point, not of the mean
  int points = 0;
};

// The normal distributions transform of `points` (P. Biber, W. Strasser, "The normal distributions transform: a new
// approach to laser scan matching", 2003; M. Magnusson, "The three-dimensional normal-distributions transform", 2009):
// cells of `side` (m) with at least kFewestNdtPoints points, row by row. A variance is at least kThinnest of the other
// one, so that cells of straight walls can be inverted (Magnusson, section 6.2).
std::vector<NdtCell> NdtOf(const std::vector<Eigen::Vector2d>& points, double side);

constexpr int kFewestNdtPoints = 4;
constexpr double kThinnest = 1e-3;

}  // namespace enfilade::prior
