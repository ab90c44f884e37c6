// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "core/prior/correction/plan_displacement.h"

namespace enfilade::prior {

// A wall as an edge between its corners' places: easy to stretch, hard to turn.
struct WallSpring {
  int from = 0;  // index of a corner
  int to = 0;
};

struct SpringOptions {
  double stretch_per_metre = 0.1;  // m^2 for each m of wall: the variance along it
  double across = 0.05;            // m^2: the variance across it
  double loose = 25.0;             // m^2: of corners that nothing holds
};

// The walls of a plan as springs, as the Auto-Complete Graph has them (M. Mielle, M. Magnusson, A. Lilienthal, "The
// Auto-Complete Graph: Merging and Mutual Correction of Sensor and Prior Maps for SLAM", Robotics 2019): corners are
// variables, and each wall holds its two corners together. The offsets of walls pull both of a wall's corners. To
// compare with: nothing here knows of a distortion of the whole plan. Immutable.
class WallSprings : public PlanDisplacement {
 public:
  // `corners`: m, before the correction. `weights`: of the offsets, in (0, 1]; empty: 1.
  WallSprings(const SpringOptions& options, std::vector<Eigen::Vector2d> corners, const std::vector<WallSpring>& walls,
              std::vector<PlanOffset> offsets, const std::vector<double>& weights);

  // A place on no wall moves with the nearest corner.
  Displacement At(const PlanPlace& place) const override;
  Eigen::Vector2d MeanAt(const PlanPlace& place) const override;
  std::vector<double> SurpriseOf(const std::vector<int>& groups) const override;

 private:
  // d(displacement at the place) / d(displacements of the corners), a column for each component.
  Eigen::SparseMatrix<double> InfluenceOn(const PlanPlace& place) const;

  std::vector<Eigen::Vector2d> corners_;
  std::vector<PlanOffset> offsets_;
  Eigen::VectorXd variances_;             // m^2, of the offsets, by their weights
  Eigen::SparseMatrix<double> jacobian_;  // of the offsets, a column each
  std::unique_ptr<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>> information_;
  Eigen::VectorXd moves_;  // m, x and y of each corner
};

}  // namespace enfilade::prior
