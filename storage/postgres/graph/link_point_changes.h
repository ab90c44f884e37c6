// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "storage/link_point_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// Changes of link points as parts of a transaction that holds the site's graph at `version` (RaiseGraphVersion). What
// they say of errors is what LinkPointStore says.

// INVALID_ARGUMENT: as ValidateAnchors, and a direction without an anchor.
absl::Status ValidateLinkPoint(const StoredLinkPoint& link_point);

absl::Status InsertLinkPoint(Transaction& transaction, const StoredLinkPoint& link_point, std::int64_t version,
                             const std::string& request_id);
// Writes all but use and what the store sets; anchors that are gone take their evidence along.
absl::Status UpdateLinkPoint(Transaction& transaction, const StoredLinkPoint& link_point, std::int64_t version);
// `etag` 0: whatever it is.
absl::Status RemoveLinkPoint(Transaction& transaction, const SiteId& site, const LinkPointId& id, std::int64_t etag);

// Adds anchors behind those that are there, or writes those that are. Queued only: ExplainLinkPoint tells of errors.
void QueueAnchors(Transaction& transaction, const SiteId& site, const LinkPointId& id,
                  const std::vector<graph::Anchor>& anchors);
// What the schema says, in the words of the API.
absl::Status ExplainLinkPoint(const absl::Status& status, const SiteId& site, const graph::LinkPoint& point);
// Why a change that asks for an etag touched no row: NOT_FOUND or ABORTED.
absl::Status WhyUntouched(Transaction& transaction, const SiteId& site, const LinkPointId& id);

// Takes the place of what the anchor had of these kinds. Queued only; 23503 where an anchor or a blob is missing.
void QueueEvidence(Transaction& transaction, const SiteId& site, const std::vector<Evidence>& evidence);

// The resource of a link point in the graph's history.
inline std::string ResourceOf(const LinkPointId& id) { return "linkPoints/" + id.value(); }

}  // namespace enfilade::storage::postgres
