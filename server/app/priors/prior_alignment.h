// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/grid/map_raster.h"
#include "core/prior/fit/fit_plan.h"
#include "server/app/graph/site_graphs.h"
#include "server/app/priors/level_maps.h"
#include "storage/call_context.h"
#include "storage/graph/plan_join_store.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/map_store.h"
#include "storage/maps/prior_map_store.h"
#include "storage/maps/revision_store.h"

namespace enfilade::server {

// What became of a prior map that was aligned with the maps of its level.
struct AlignedPriorMap {
  storage::PriorMapOutcome outcome;
  std::vector<double> pair_residuals;  // m, of each pair; empty if it was not accepted
};

// Finds plans in the maps of their level, as they lie in the world by the graph, without what plans have done to it,
// and in those that no link points join to the root map, each by itself. If none of the level is joined to it, the
// shafts of the plan say where the level lies (level_apart.h). Thread-safe; each call computes for seconds, on up to
// `threads` threads.
class PriorAlignment {
 public:
  PriorAlignment(const storage::PriorMapStore& prior_maps, const storage::PlanJoinStore& plan_joins,
                 const storage::MapReader& maps, const storage::RevisionStore& revisions,
                 const storage::BlobStore& blobs, SiteGraphs& graphs, int threads = 1)
      : prior_maps_(prior_maps),
        plan_joins_(plan_joins),
        maps_(maps),
        revisions_(revisions),
        blobs_(blobs),
        graphs_(graphs),
        threads_(threads) {}

  // Nothing is stored. `from_last`: it is looked for only where its last alignment has placed it, which must exist;
  // without pairs. INVALID_ARGUMENT: pairs that determine nothing, or in a map that is not among those of the level;
  // FAILED_PRECONDITION: no map of the level has walls and a place in the world, and the plan has no two shafts that
  // plans in use of other levels have; DATA_LOSS.
  absl::StatusOr<AlignedPriorMap> Align(const storage::CallContext& context, const storage::PriorMap& prior_map,
                                        const std::vector<storage::PriorMapPair>& pairs, bool from_last,
                                        bool activate) const;

  // A prior map in use with the maps as they are now, from where it lies; it stays in use if it still fits them.
  // Nothing is stored. FAILED_PRECONDITION: it has no alignment, or as above; DATA_LOSS.
  absl::StatusOr<AlignedPriorMap> AlignAgain(const storage::CallContext& context,
                                             const storage::PriorMap& prior_map) const;

 private:
  // How the plan is placed in the level's maps.
  struct Placement {
    prior::FitOptions options;
    storage::PriorMapState accepted_state = storage::PriorMapState::kProposed;
  };

  // By its last alignment, and by how the maps have moved since.
  static prior::PlanTransform PlaceNow(const storage::PriorMap& prior_map, const LevelMaps& level);
  absl::StatusOr<AlignedPriorMap> Fit(const storage::CallContext& context, const storage::PriorMap& prior_map,
                                      LevelMaps level, const Placement& placement) const;

  absl::StatusOr<LevelMaps> ReadLevel(const storage::CallContext& context, const storage::PriorMap& prior_map) const;
  absl::StatusOr<grid::MapRaster> ReadRaster(const storage::CallContext& context, const storage::Map& map) const;

  const storage::PriorMapStore& prior_maps_;
  const storage::PlanJoinStore& plan_joins_;
  const storage::MapReader& maps_;
  const storage::RevisionStore& revisions_;
  const storage::BlobStore& blobs_;
  SiteGraphs& graphs_;
  const int threads_;
};

}  // namespace enfilade::server
