// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/prior/plan/plan_graph.h"

namespace enfilade::perception {

// A distance that is known: between two points of the sheet, or of the photo of it.
struct PlanMeasure {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  double metres = 0;
};

// By the measured distance.
inline double MetresPerUnit(const PlanMeasure& measure, const prior::PlanGraph& plan) {
  return measure.metres / (prior::ToSheet(plan, measure.to) - prior::ToSheet(plan, measure.from)).norm();
}

}  // namespace enfilade::perception
