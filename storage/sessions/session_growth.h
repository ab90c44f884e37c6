// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "core/base/time.h"
#include "core/sensor/record.h"
#include "storage/sessions/session_store.h"

namespace enfilade::storage {

// The change of a session's row by the records added to its log.
struct SessionGrowth {
  std::int64_t acknowledged = 0;  // as stored; advanced by records that follow without a hole
  std::int64_t highest = 0;       // likewise
  // The record after `acknowledged` was added while later ones were stored: the caller must look up where the run
  // without holes ends now.
  bool filled_hole = false;
  RecordCounts counts;  // added
  std::int64_t payload_bytes = 0;
  std::optional<TimeNs> first_time;
  std::optional<TimeNs> last_time;

  // `record` is not stored yet. Records come in any order.
  void Add(const sensor::Record& record, std::int64_t record_bytes);
};

}  // namespace enfilade::storage
