// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "storage/link_point_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// Changes of validated link points, as parts of a transaction that has locked the site's graph at `version`
// (RaiseGraphVersion). Errors as in LinkPointStore.

absl::Status InsertLinkPoint(Transaction& transaction, const StoredLinkPoint& link_point, std::int64_t version,
                             const std::string& request_id);
// As LinkPointStore::Update.
absl::Status UpdateLinkPoint(Transaction& transaction, const StoredLinkPoint& link_point, std::int64_t version);
// `etag` 0: any.
absl::Status RemoveLinkPoint(Transaction& transaction, const SiteId& site, const LinkPointId& id, std::int64_t etag);

// Appends new anchors and writes existing ones. Queued only: pass the error to ExplainLinkPoint.
void QueueAnchors(Transaction& transaction, const SiteId& site, const LinkPointId& id,
                  const std::vector<graph::Anchor>& anchors);
// An error of the schema in terms of the API.
absl::Status ExplainLinkPoint(const absl::Status& status, const SiteId& site, const graph::LinkPoint& point);
// Why a change with an etag affected no row: NOT_FOUND or ABORTED.
absl::Status WhyUnchanged(Transaction& transaction, const SiteId& site, const LinkPointId& id);

// The resource of a link point in the graph's history.
inline std::string ResourceOf(const LinkPointId& id) { return "linkPoints/" + id.value(); }

}  // namespace enfilade::storage::postgres
