// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/graph/rearrangement_rules.h"
#include "storage/graph/rearrangement_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// The kinds of rows in enfilade.rearrangement_parts.
enum class RearrangementPart : std::int16_t {
  kNewMap = 1,
  kCut = 2,
  kMove = 3,
  kStoredLinkPoint = 4,
  kRemovedLinkPoint = 5,
  kRedirect = 6,
};

// Stores the rearrangement with its parts, by which all other statements find what they change. Queued only.
void QueueRearrangement(Transaction& transaction, const SiteId& site, const RearrangementChange& change,
                        std::int64_t version);

// NOT_FOUND.
absl::StatusOr<StoredRearrangement> ReadRearrangement(Transaction& transaction, const SiteId& site,
                                                      const rearrange::RearrangementId& id);
// As RearrangementStore::List.
absl::StatusOr<std::vector<StoredRearrangement>> ReadRearrangements(Transaction& transaction, const SiteId& site,
                                                                    std::int64_t before, int limit);

// Places the rearrangement's link points, those that exist, in the world. The graph is locked at `version`.
absl::Status PlaceLinkPointsOf(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id,
                               std::int64_t version);

}  // namespace enfilade::storage::postgres
