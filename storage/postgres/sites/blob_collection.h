// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "storage/postgres/driver/pool.h"
#include "storage/sites/maintenance.h"

namespace enfilade::storage::postgres {

// Maintenance::CollectBlobs in one site, in one or two short transactions. Each blob without references is in the list
// loose_blobs: triggers add it when it is stored and when a reference to it goes, and whoever looks at it takes it from
// the list. So what is looked at does not grow with the blobs in use. An entry that another replica looks at is
// skipped.
absl::StatusOr<MaintenancePortion> CollectBlobsOf(Pool& pool, const CallContext& context, const SiteId& site,
                                                  std::chrono::seconds grace, std::int64_t limit);

}  // namespace enfilade::storage::postgres
