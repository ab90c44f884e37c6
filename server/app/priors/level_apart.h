// SPDX-License-Identifier: Apache-2.0
// Levels of which no map is joined to the root map: they are laid out by their own link points, and placed in the world
// by the shafts that their plan shares with plans of other levels.
#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/geometry/pose2.h"
#include "core/graph/graph_snapshot.h"
#include "core/graph/plans/plan_ties.h"
#include "core/prior/alignment/plan_transform.h"
#include "core/prior/fit/fit_plan.h"
#include "core/prior/plan/plan_graph.h"
#include "server/app/priors/level_maps.h"
#include "storage/maps/prior_map_store.h"

namespace enfilade::server {

// Moves the unjoined map with the most walls, and those that link points join to it, to `level.maps`, in the frame of
// that one. `graph` has no plans. Without maps it does nothing. Errors of OptimizeGraph.
absl::Status LayOutApart(const graph::GraphSnapshot& graph, LevelMaps& level);

// FAILED_PRECONDITION: no map of the level has walls, or fewer than two shafts of the plan have a name that a shaft of
// a plan in use of another level has: no place can be found.
absl::Status CheckShafts(const prior::PlanGraph& plan, const storage::PriorMap& prior_map, const LevelMaps& level);

struct ApartLevelPlace {
  std::optional<Pose2> T_world_level = std::nullopt;  // of the frame of LevelMaps::maps; unset: it has no place
  prior::PlanTransform T_level_sheet = {};            // of the plan in that frame
  double rival_ratio = 0;                             // prior::Alignment::rival_ratio
  std::string reason = {};                            // what the place rests on, or why there is none
};

// Finds the plan in the maps of a level that is apart, and the level in the world, by the shafts that the plan shares
// with plans in use of other levels. `options`: in the frame of LevelMaps::maps. Errors of FitPlan.
absl::StatusOr<ApartLevelPlace> PlaceApartLevel(const prior::PlanGraph& plan, const storage::PriorMap& prior_map,
                                                const LevelMaps& level, const prior::FitOptions& options);

// Whether the plan, if it were used with these ties, would contradict plans in use of other levels: most of the shafts
// that it shares with them lie elsewhere. Empty: it does not, or shares none. Takes an optimisation if it shares one.
absl::StatusOr<std::string> ObjectionOfShafts(const graph::GraphSnapshot& graph, const storage::PriorMap& prior_map,
                                              const graph::PlanTies& ties);

}  // namespace enfilade::server
