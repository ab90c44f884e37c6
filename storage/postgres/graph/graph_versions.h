// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "storage/graph/graph_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

constexpr Statement kSelectGraphVersion{"reading the graph's version",
                                        "SELECT graph_version FROM enfilade.site_graphs WHERE site_id = $1"};
// Of the notifications of new versions: "SITE VERSION" (GraphListener).
#define ENFILADE_GRAPH_CHANNEL "enfilade_graph"
// Listeners hear of the version once the transaction has committed.
void NotifyOfGraph(Transaction& transaction, const SiteId& site, std::int64_t version);
// Executes the queue, and does the same for the version to which a trigger has raised the graph.
absl::Status NotifyOfPresentGraph(Transaction& transaction, const SiteId& site);
// 0 if the site has no maps.
absl::StatusOr<std::int64_t> ReadGraphVersion(const Result& result);

// Every writer of a site's graph starts with one of these, so that the writers of a site follow one another. Locks are
// taken in the order site's graph, lease, map, session.

// Locks the site's graph. Queued only.
void QueueGraphLock(Transaction& transaction, const SiteId& site);
// Locks it and returns its version; 0 if the site has no maps.
absl::StatusOr<std::int64_t> LockGraph(Transaction& transaction, const SiteId& site);
// Locks the site's graph and returns its new version, made by a change of `resource`. NOT_FOUND if the site does not
// exist.
absl::StatusOr<std::int64_t> RaiseGraphVersion(Transaction& transaction, const SiteId& site, GraphCause cause,
                                               const std::string& resource);
// Records a removal for those who keep a copy of the graph. Queued only.
void QueueRemoval(Transaction& transaction, const SiteId& site, const MapId& map);
void QueueRemoval(Transaction& transaction, const SiteId& site, const LinkPointId& link_point);

}  // namespace enfilade::storage::postgres
