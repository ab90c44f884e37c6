// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/sensor/record.h"

namespace enfilade::sensor {

// The bytes of a payload in spools and in the record log: little-endian, a version byte first, exact (every double,
// float and nanosecond is restored bit for bit). Stored data outlives programs: a new layout gets a new version byte
// and old layouts stay readable.
std::string EncodePayload(const Record& record);

// Appends to `out`, for callers that build large buffers.
void AppendPayload(const Record& record, std::string& out);

// DATA_LOSS on truncated, trailing or unknown bytes.
absl::StatusOr<Record> DecodePayload(std::int64_t sequence, RecordKind kind, std::string_view bytes);

}  // namespace enfilade::sensor
