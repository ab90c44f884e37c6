// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/grid/occupancy_grid.h"
#include "core/prior/alignment/map_evidence.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/correction/correct_plan.h"

namespace enfilade::prior {

// Where one map lies in another's frame, if a plan lies in both as given: the turn and shift that bring the walls of
// `evidence` nearest to where the plan puts them in the other map (S. Umeyama, "Least-squares estimation of
// transformation parameters between two point patterns", 1991, without the scale).
Pose2 JoinByPlan(const MapEvidence& evidence, const PlanTransform& T_map_sheet, const PlanTransform& T_other_sheet);

// The map's place, T_frame_map, moved so that its walls lie on those of the other maps (`others`, in `frame`), and
// where these have seen nothing on those of the corrected plan.
Pose2 RefineAmong(const MapEvidence& evidence, const MapEvidence& others, const CorrectedPlan& corrected,
                  const Pose2& T_frame_map);

// How much of the straight walls of each of two maps, where the other knows the ground, lies amid free ground of that,
// as a share; 0 where they have less than 3 m of such walls. `T_other_map`: where the one lies in the other.
double ContradictedShare(const MapEvidence& map, const MapEvidence& other, const Pose2& T_other_map);

struct PlacedMap {
  const grid::OccupancyGrid* map = nullptr;
  const MapEvidence* evidence = nullptr;  // of the map
  Pose2 T_frame_map = {};
};

// The maps as one, the later ones on top, with cells as large as the first's. Ground that a map does not know
// (MapEvidence) is left to the others. INVALID_ARGUMENT: too large.
absl::StatusOr<grid::OccupancyGrid> Overlaid(const std::vector<PlacedMap>& maps);

}  // namespace enfilade::prior
