// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/prior/formats/dxf_plan.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

// The lines of an SVG 1.1 drawing: line, polyline, polygon, rect, and path with curves as chords; groups, transforms,
// and `use` of elements of the same file, up to eight within each other. `layers` (IsWantedLayer) are the labels, ids
// or classes of groups or of the element itself. Thickness is the width of the stroke. The sheet is the user space of
// the outermost svg. What is not displayed, clip paths, patterns and dashed lines are left out.
// Nothing is fetched or executed: scripts, pictures and references to other files are left out with a warning, and
// entities are not expanded. INVALID_ARGUMENT: no SVG, or damaged; RESOURCE_EXHAUSTED: more than kMostWalls lines.
absl::StatusOr<VectorPlan> ReadSvgPlan(std::string_view text, const std::vector<std::string>& layers = {});

// The walls as lines, as thick as they are; rooms' names as texts. The sheet holds the origin.
std::string WriteSvgPlan(const PlanGraph& plan);

}  // namespace enfilade::prior
