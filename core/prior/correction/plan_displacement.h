// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace enfilade::prior {

// A place of a plan whose displacement is asked for or measured. A place on a wall moves with the wall's two corners.
struct PlanPlace {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();  // m, in the map's frame, before the correction
  std::array<int, 2> corners = {-1, -1};            // -1: none
  std::array<double, 2> shares = {0, 0};            // of each corner's own displacement
};

// How far a wall is from where the plan has it, across it: along the wall, nobody can see it move.
struct PlanOffset {
  PlanPlace place;
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();  // unit, in the map's frame
  double offset = 0;                                 // m, along the normal
  double sigma = 0.06;                               // m
};

struct Displacement {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();        // m
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // m^2
};

// How all of a plan is displaced, given the offsets of some of its walls. Immutable.
class PlanDisplacement {
 public:
  virtual ~PlanDisplacement() = default;

  virtual Displacement At(const PlanPlace& place) const = 0;
  virtual Eigen::Vector2d MeanAt(const PlanPlace& place) const = 0;
  // How surprising the offsets of each group are to all others: the mean squared error, in standard deviations, of what
  // the others predict (1 is usual). `groups`: of each offset, from 0 on.
  virtual std::vector<double> SurpriseOf(const std::vector<int>& groups) const = 0;
};

// The indices of each group's members.
std::vector<std::vector<Eigen::Index>> MembersOf(const std::vector<int>& groups);

}  // namespace enfilade::prior
