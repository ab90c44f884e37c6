// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "storage/graph_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

constexpr Statement kSelectGraphVersion{"reading the graph's version",
                                        "SELECT graph_version FROM enfilade.site_graphs WHERE site_id = $1"};
// 0 where the site has no maps.
absl::StatusOr<std::int64_t> ReadGraphVersion(const Result& result);

// Every writer of a site's graph begins with one of these, so that writers of one site follow one another: locks are
// taken in the order site's graph, lease, map, session.

// Holds the site's graph without changing it. Queued only.
void QueueGraphLock(Transaction& transaction, const SiteId& site);
// Holds it at once and gives its version; 0 where the site has no maps.
absl::StatusOr<std::int64_t> LockGraph(Transaction& transaction, const SiteId& site);
// As GraphStore::ReadChanges, of a graph that this transaction holds.
absl::StatusOr<GraphChanges> ReadHeldGraph(Transaction& transaction, const SiteId& site, std::int64_t since);
// Holds the site's graph and gives its new version, made by a change of `resource`. NOT_FOUND where the site is
// missing.
absl::StatusOr<std::int64_t> RaiseGraphVersion(Transaction& transaction, const SiteId& site, GraphCause cause,
                                               const std::string& resource);
// What is gone, for those who keep a copy of the graph. Queued only.
void QueueRemoval(Transaction& transaction, const SiteId& site, const MapId& map);
void QueueRemoval(Transaction& transaction, const SiteId& site, const LinkPointId& link_point);

}  // namespace enfilade::storage::postgres
