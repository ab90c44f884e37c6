// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/base/ids.h"
#include "core/closure/door_verdict.h"
#include "storage/postgres/driver/result.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// The columns that ReadVerdict reads.
#define ENFILADE_VERDICT_COLUMNS                                                                           \
  "session_id, sequence, decision, link_point_id, map_id, x, y, yaw, coalesce(covariance, '{}'), odom_x, " \
  "odom_y, odom_yaw, evidence::float8[], reason, graph_version, create_time"

// Without its comparisons.
closure::DoorVerdict ReadVerdict(Row& row);

struct ComparisonRow {
  std::int64_t sequence = 0;  // of the verdict
  closure::DoorComparison comparison;
};
ComparisonRow ReadComparison(Row& row);

// Stores a verdict with its comparisons. Queued only.
void QueueVerdict(Transaction& transaction, const SiteId& site, const closure::DoorVerdict& verdict);

}  // namespace enfilade::storage::postgres
