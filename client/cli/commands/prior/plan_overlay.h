// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "core/grid/files/rgb_image.h"
#include "core/prior/plan/plan_graph.h"
#include "perception/image/frame.h"

namespace enfilade::cli {

// The plan over its picture, which is drawn pale; without a picture, on white, scaled to 1600 px. Walls are red, the
// paler the less certain; doors blue, corners green dots, shafts orange.
grid::RgbImage DrawPlan(const prior::PlanGraph& plan, const std::optional<perception::GreyFrame>& picture);

}  // namespace enfilade::cli
