// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/files/map_files.h"
#include "core/prior/correction/correct_plan.h"
#include "core/prior/fit/fit_plan.h"
#include "core/prior/plan/plan_graph.h"

// What people and programs get of a plan that was fitted to maps, as files. The frame is that of the joined maps: m, y
// upwards. Fits are accepted ones.
namespace enfilade::prior {

std::string_view NameOf(Sight sight);  // seen, unseen, contradicted

// walls.geojson (a FeatureCollection: each wall with its `state`, `stretch`, `thickness` (m) and `sigma_m`; walls that
// only robots have seen, with the state `added`; then each door with `state` and `sigma_m`), report.json (WriteReport),
// walls.svg and walls.building.yaml.
std::vector<grid::MapFile> CorrectedFiles(const PlanGraph& plan, const PlanFit& fit);

// The planning map as planning.yaml with its picture, and planning-mask.png, a grey pixel for each cell: 0 unknown, 1
// seen by a robot, 2 predicted by the plan. Errors of MakePlanningMap.
absl::StatusOr<std::vector<grid::MapFile>> PlanningFiles(const PlanGraph& plan, const PlanFit& fit,
                                                         grid::MapFileFormat format);

// fit.png: the map, the plan as it was placed (grey) and corrected (seen green, unseen blue, contradicted red), and
// walls that only robots have seen (orange).
absl::StatusOr<grid::MapFile> PictureFile(const PlanGraph& plan, const PlanFit& fit);

}  // namespace enfilade::prior
