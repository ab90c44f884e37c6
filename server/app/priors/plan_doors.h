// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/closure/plans/plan_doors.h"
#include "core/graph/plans/plan_ties.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/prior_map_store.h"

namespace enfilade::server {

constexpr const char* kCorrectedWalls = "walls.geojson";  // of an alignment's PriorMapProduct::kCorrected

struct CorrectedDoors {
  closure::PlanWithDoors plan;  // without its maps; the doors are in the order of the file
  std::vector<bool> seen;       // of each door: robots have seen the ground there
};

// The walls and doors of a walls.geojson. DATA_LOSS.
absl::StatusOr<CorrectedDoors> ParseCorrectedDoors(const std::string& bytes);

// The doors of a plan with these ties, as its last alignment has corrected them. None if it was aligned by a server
// that stored no walls. DATA_LOSS.
absl::StatusOr<closure::PlanWithDoors> ReadPlanDoors(const storage::CallContext& context,
                                                     const storage::PriorMapStore& prior_maps,
                                                     const storage::BlobStore& blobs, const SiteId& site,
                                                     const PriorMapId& id, const graph::PlanTies& ties);

}  // namespace enfilade::server
