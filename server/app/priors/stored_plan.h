// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "core/prior/plan/plan_graph.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"
#include "storage/maps/prior_map_store.h"

namespace enfilade::server {

// The walls of a stored plan, as people have corrected them. NOT_FOUND: it was deleted meanwhile; DATA_LOSS.
absl::StatusOr<prior::PlanGraph> ReadStoredPlan(const storage::CallContext& context,
                                                const storage::PriorMapStore& prior_maps,
                                                const storage::BlobStore& blobs, const storage::PriorMap& prior_map);

}  // namespace enfilade::server
