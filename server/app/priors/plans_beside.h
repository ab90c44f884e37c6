// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/graph/plans/plan_ties.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/prior_map_store.h"

namespace enfilade::server {

// The other plans in use on a plan's level.
struct PlansBeside {
  std::vector<std::int64_t> etags = {};                // of each
  std::optional<PriorMapId> same_area = std::nullopt;  // one that has walls where the plan has its own
};

// Two plans of the same rooms would pull at the same maps: each error of the one would be a contradiction to the other.
// So only one of them can be in use. `ties`: of the plan.
absl::StatusOr<PlansBeside> FindPlansBeside(const storage::CallContext& context,
                                            const storage::PriorMapStore& prior_maps, const storage::BlobStore& blobs,
                                            const storage::PriorMap& prior_map, const graph::PlanTies& ties);

// The ties of a stored plan; none if it is not aligned or was by a server that made none.
absl::StatusOr<std::optional<graph::PlanTies>> ReadTies(const storage::CallContext& context,
                                                        const storage::PriorMapStore& prior_maps,
                                                        const storage::BlobStore& blobs, const SiteId& site,
                                                        const PriorMapId& id);

}  // namespace enfilade::server
