// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/prior/plan/plan_graph.h"

namespace enfilade::prior {

struct VectorPlan {
  PlanGraph graph;  // one wall for each line of the drawing, not planar
  std::vector<std::string> warnings;
};

// The lines of an ASCII DXF drawing: LINE, LWPOLYLINE and POLYLINE (with bulges), ARC, and INSERT of blocks, up to
// eight blocks within each other. Only layers that match `layers` (IsWantedLayer) are read; blocks take the layer of
// their own lines. Metres per unit by $INSUNITS; a warning if it names none. y is turned over. INVALID_ARGUMENT: not
// such a file, or a damaged one; blocks that contain themselves; RESOURCE_EXHAUSTED: more than kMostWalls lines.
absl::StatusOr<VectorPlan> ReadDxfPlan(std::string_view text, const std::vector<std::string>& layers = {});

}  // namespace enfilade::prior
