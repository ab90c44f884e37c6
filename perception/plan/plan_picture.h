// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/prior/plan/plan_graph.h"
#include "perception/image/frame.h"

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

struct PicturedPlan {
  prior::PlanGraph graph;  // without rooms
  GreyFrame picture;       // as it was read: of a photo of a page, the page
};

// Recognises the walls and doors of a plan that is a picture. The photo of a page is rectified before. Errors as
// DecodeSheet (opencv_sheet.h).
absl::StatusOr<PicturedPlan> RecognisePlan(std::string_view bytes, const std::optional<PlanMeasure>& measure);

}  // namespace enfilade::perception
