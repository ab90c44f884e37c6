// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "storage/graph/link_point_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// Changes of link points as parts of a transaction. Each locks the site's graph, raises its version, and places the
// link point again. Errors as in LinkPointStore; afterwards the transaction must be abandoned. Whether a link point is
// redundant is decided here (CheckNotRedundant); the triggers of migrations/deploy/link_points.sql are a last line of
// defence.

absl::Status InsertLinkPoint(Transaction& transaction, const StoredLinkPoint& link_point, const RequestId& request_id);
absl::Status UpdateLinkPoint(Transaction& transaction, const StoredLinkPoint& link_point);
absl::Status InsertAnchor(Transaction& transaction, const SiteId& site, const NewAnchor& added);
absl::Status SetSuspended(Transaction& transaction, const SiteId& site, const LinkPointId& id, std::int64_t etag,
                          bool suspended);
absl::Status RemoveLinkPoint(Transaction& transaction, const SiteId& site, const LinkPointId& id, std::int64_t etag);
// Any of them.
absl::Status ChangeLinkPoint(Transaction& transaction, const SiteId& site, const LinkPointChange& change);

}  // namespace enfilade::storage::postgres
