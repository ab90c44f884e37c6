// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string_view>

#include "core/prior/formats/geojson_plan.h"
#include "core/prior/plan/plan_check.h"
#include "perception/plan/read_plan.h"
#include "tests/fuzz/decoder.h"

namespace enfilade::fuzz {

// What holds of the lines of a drawing before they become a plan.
inline void ExpectLines(const prior::PlanGraph& plan) {
  Expect(plan.walls.size() <= prior::kMostWalls, "a drawing has no more lines than a plan may have walls");
  for (const prior::PlanWall& wall : plan.walls) {
    const int count = static_cast<int>(plan.corners.size());
    Expect(wall.from >= 0 && wall.from < count && wall.to >= 0 && wall.to < count, "a line has both its ends");
    Expect(plan.corners[wall.from].point.allFinite() && plan.corners[wall.to].point.allFinite(), "a line is finite");
    Expect(prior::LengthOf(plan, wall) > 0, "a line has a length");
    Expect(std::isfinite(wall.thickness) && wall.thickness >= 0, "a line has a thickness");
  }
}

// What holds of every file that is read as a plan: it is valid, and GeoJSON keeps it.
inline void ExpectPlanFile(std::string_view bytes) {
  const auto file = perception::DecodePlan(bytes);
  if (!file.ok()) {
    Expect(file.status().code() == absl::StatusCode::kInvalidArgument ||
               file.status().code() == absl::StatusCode::kResourceExhausted,
           "a file that is no plan is refused as such");
    return;
  }
  Expect(prior::CheckPlan(file->graph).ok(), "a plan is valid");
  const std::string written = prior::WriteGeoJsonPlan(file->graph);
  const auto again = prior::ReadGeoJsonPlan(written);
  Expect(again.ok() && prior::WriteGeoJsonPlan(*again) == written, "a plan is read back");
}

}  // namespace enfilade::fuzz
