// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/geometry/pose2.h"

namespace enfilade::prior {

// The plan frame: that of the sheet in metres, as far as its scale is known: (x, -y) * metres per unit of the sheet, so
// that y points up. A plan metre is the length of the plan that stands for a metre.

// Where a robot is in a plan that is drawn at a wrong scale, and not the same along both of its axes.
struct PlanState {
  double x = 0;  // plan metres
  double y = 0;
  double yaw = 0;          // rad, in the plan frame; where the plan is mirrored, turns to the left go to its right
  double log_scale = 0;    // ln of the metres that a plan metre is, the mean of both axes
  double log_stretch = 0;  // ln of the metres along the plan's first axis, less log_scale; the second has the opposite
  bool mirrored = false;

  Eigen::Vector2d translation() const { return {x, y}; }
};

// From displacements in the robot's frame, m, to the plan frame, plan metres. `axis`: the angle of the plan's first
// axis, rad.
Eigen::Matrix2d LinearOf(const PlanState& state, double axis);

// From displacements in the plan frame, plan metres, to metres along the same directions.
Eigen::Matrix2d MetresOf(const PlanState& state, double axis);

// After a motion in the robot's frame. Scale and stretch stay.
PlanState Moved(const PlanState& state, const Pose2& motion, double axis);

}  // namespace enfilade::prior
