// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/prior/plan/plan_graph.h"
#include "perception/image/frame.h"

namespace enfilade::perception {

struct PicturedPlan {
  prior::PlanGraph graph;  // without rooms
  GreyFrame picture;
};

// Recognises the walls and doors of a plan that is a picture. Errors as DecodeSheet (opencv_sheet.h).
absl::StatusOr<PicturedPlan> RecognisePlan(std::string_view bytes, std::optional<double> metres_per_unit);

}  // namespace enfilade::perception
