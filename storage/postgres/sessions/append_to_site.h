// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/base/ids.h"
#include "storage/call_context.h"
#include "storage/postgres/driver/pool.h"
#include "storage/sessions/record_store.h"

namespace enfilade::storage::postgres {

// RecordStore::AppendGroup for batches of one site: one transaction.
std::vector<absl::StatusOr<AppendResult>> AppendToSite(Pool& pool, const CallContext& context, const SiteId& site,
                                                       absl::Span<const RecordBatch* const> batches);

}  // namespace enfilade::storage::postgres
