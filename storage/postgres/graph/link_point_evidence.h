// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/graph/link_point_store.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// Replaces the evidence of these kinds at each anchor. Queued only; SQLSTATE 23503 if an anchor or a blob is missing.
void QueueEvidence(Transaction& transaction, const SiteId& site, const std::vector<Evidence>& evidence);

// As the methods of LinkPointStore.
absl::Status PutEvidence(Pool& pool, const CallContext& context, const SiteId& site, const Evidence& evidence);
absl::StatusOr<std::vector<Evidence>> ListEvidence(Pool& pool, const CallContext& context, const SiteId& site,
                                                   const std::vector<LinkPointId>& link_points);

}  // namespace enfilade::storage::postgres
