// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/prior/plan/plan_graph.h"
#include "perception/image/frame.h"
#include "perception/plan/plan_measure.h"

namespace enfilade::perception {

struct PicturedPlan {
  prior::PlanGraph graph;  // without rooms
  GreyFrame picture;       // as it was read: of a photo of a page, the page
};

// Recognises the walls and doors of a plan that is a picture. The photo of a page is rectified before. Errors as
// DecodeSheet (opencv_sheet.h).
absl::StatusOr<PicturedPlan> RecognisePlan(std::string_view bytes, const std::optional<PlanMeasure>& measure);

}  // namespace enfilade::perception
