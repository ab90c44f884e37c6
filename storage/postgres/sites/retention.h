// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "storage/postgres/driver/pool.h"
#include "storage/sites/maintenance.h"

namespace enfilade::storage::postgres {

// What a site's retentions (storage/sites/site_store.h) delete, in short transactions of about `limit` rows.

// Looks at maps, in the list revision_reviews: whoever stores a revision puts its map there, and so does this for when
// the map's next revision is past its retention. So maps that do not change cost nothing.
absl::StatusOr<MaintenancePortion> DeleteRevisions(Pool& pool, const CallContext& context, const SiteId& site,
                                                   std::int64_t limit);

// These return how many rows they deleted; unset if there was nothing to do.
//
// Deletes versions of the graph, and what was removed up to them. The current version stays, and so do the last
// optimisations (GraphReader::kKeptOptimizations).
absl::StatusOr<std::optional<std::int64_t>> DeleteGraphHistory(Pool& pool, const CallContext& context,
                                                               const SiteId& site, std::int64_t limit);
absl::StatusOr<std::optional<std::int64_t>> DeleteAuditEntries(Pool& pool, const CallContext& context,
                                                               const SiteId& site, std::int64_t limit);
// Deletes what is left of sessions that were deleted longer than `kept` ago.
absl::StatusOr<std::optional<std::int64_t>> ForgetSessions(Pool& pool, const CallContext& context, const SiteId& site,
                                                           std::chrono::seconds kept, std::int64_t limit);
// Marks sessions as deleted: their rows are purged later.
absl::StatusOr<std::optional<std::int64_t>> DeleteFinishedSessions(Pool& pool, const CallContext& context,
                                                                   const SiteId& site, std::int64_t limit);

}  // namespace enfilade::storage::postgres
