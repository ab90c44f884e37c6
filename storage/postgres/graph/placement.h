// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "storage/graph_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// Gives the link point its place in the world, by the anchor that leaves the least uncertain position, and through it
// (where it is used) the maps that have none yet, their link points, and so on: a first estimate, until the graph is
// optimised. The transaction holds the site's graph at `version`. Nothing happens where no map of it has a place.
absl::Status PlaceLinkPoint(Transaction& transaction, const SiteId& site, std::int64_t version,
                            const LinkPointId& link_point);

// Writes places of maps and link points, whose rows then belong to `version`. Queued only.
void QueuePlaces(Transaction& transaction, const SiteId& site, std::int64_t version, const std::vector<MapPose>& maps,
                 const std::vector<LinkPointPose>& link_points);

}  // namespace enfilade::storage::postgres
