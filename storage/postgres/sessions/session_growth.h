// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "absl/types/span.h"
#include "core/base/ids.h"
#include "core/sensor/record.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/session_store.h"

namespace enfilade::storage::postgres {

// How a session's row changes with the records that are added to its log.
struct SessionGrowth {
  std::int64_t acknowledged = 0;  // as stored; advanced by records that join on without a hole
  std::int64_t highest = 0;       // likewise
  // The record behind `acknowledged` was added while others beyond it were stored: how far the log goes now without a
  // hole is to be looked up.
  bool filled_hole = false;
  RecordCounts counts;  // added
  std::int64_t payload_bytes = 0;
  std::optional<TimeNs> first_time;
  std::optional<TimeNs> last_time;

  // `record` is not stored yet. Records come in any order.
  void Add(const sensor::Record& record, std::int64_t record_bytes);
};

// Queues the change of the rows, which the transaction has locked.
void QueueGrowth(Transaction& transaction, const SiteId& site,
                 absl::Span<const std::pair<std::string_view, const SessionGrowth*>> growths);

}  // namespace enfilade::storage::postgres
