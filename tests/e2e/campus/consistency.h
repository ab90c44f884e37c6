// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "tests/e2e/campus/drive_truth.h"
#include "tests/e2e/campus/mapped_state.h"

namespace enfilade::testing {

// Whether covariances are right: errors in units of their covariance (Bar-Shalom, Li, Kirubarajan 2001, section 5.4).
struct Consistency {
  int samples = 0;
  int inside = 0;     // errors within the 95 % ellipsoid of position and yaw
  double nees = 0.0;  // sum of normalised squared errors per degree of freedom; its mean is 1 if covariances are right
  double squares = 0.0;  // m^2, sum of squared errors of the position

  // `error`: x, y (m) and yaw (rad), in the frame that the covariance is in. Certain poses (a singular covariance) do
  // not count.
  void Add(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance);
  void Add(const Consistency& other);

  double inside_share() const { return samples > 0 ? static_cast<double>(inside) / samples : 0.0; }
  double mean_nees() const { return samples > 0 ? nees / samples : 0.0; }
  double rms() const;
};

// Of a graph that has come to rest. A map's true frame is the one in which its poses fit the truth best.
struct GraphConsistency {
  Consistency joins;                    // one map's pose in another, across the link point that joins them
  Consistency chains;                   // the same across two or more link points: what a robot's pose is chained along
  Consistency maps;                     // maps' poses in the world, relative to the root
  std::optional<Pose2> T_campus_world;  // the root's true frame, if it is known
};

GraphConsistency MeasureConsistency(const std::vector<DriveTruth>& truths, const MappedState& state);

}  // namespace enfilade::testing
