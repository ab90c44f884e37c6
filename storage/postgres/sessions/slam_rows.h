// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/base/ids.h"
#include "core/slam/slam_map.h"
#include "storage/postgres/driver/result.h"
#include "storage/postgres/driver/transaction.h"

namespace enfilade::storage::postgres {

// In the order of ReadLoopClosure.
#define ENFILADE_LOOP_CLOSURE_COLUMNS \
  "closure_id, submap_id, node_id, x, y, yaw, information, state, score, chi2, reason"
slam::LoopClosure ReadLoopClosure(Row& row);

// Queues the delta's rows. Existing ones are overwritten, so that the same delta may be stored twice.
void QueueDelta(Transaction& transaction, const SiteId& site, const SessionId& session, const slam::SlamDelta& delta);

// By id.
absl::StatusOr<std::vector<slam::SlamNode>> ListNodes(Pool& pool, const CallContext& context, const SiteId& site,
                                                      const SessionId& session);

// Queues four statements whose results ReadSlamMap takes, in that order.
void QueueSlamMap(Transaction& transaction, const SiteId& site, const SessionId& session);
absl::StatusOr<slam::SlamMap> ReadSlamMap(const Result& submaps, const Result& nodes, const Result& closures,
                                          const Result& trajectory);

}  // namespace enfilade::storage::postgres
