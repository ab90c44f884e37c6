// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "storage/graph/graph_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// As GraphStore::ReadChanges.
absl::StatusOr<GraphChanges> ReadGraphChanges(Pool& pool, const CallContext& context, const SiteId& site,
                                              std::int64_t since);
// The same of a graph that this transaction has locked.
absl::StatusOr<GraphChanges> ReadLockedGraph(Transaction& transaction, const SiteId& site, std::int64_t since);

}  // namespace enfilade::storage::postgres
