// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "storage/graph/graph_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// Gives the link point its place in the world, and through it the maps and link points that have none yet
// (graph::Placement). The transaction has locked the site's graph at `version` and stored the link point. Changes
// nothing if none of its maps has a place.
absl::Status PlaceLinkPoint(Transaction& transaction, const SiteId& site, std::int64_t version,
                            const graph::LinkPoint& link_point);

// Writes places of maps and link points, whose rows then belong to `version`. Queued only.
void QueuePlaces(Transaction& transaction, const SiteId& site, std::int64_t version, const std::vector<MapPose>& maps,
                 const std::vector<LinkPointPose>& link_points);

}  // namespace enfilade::storage::postgres
