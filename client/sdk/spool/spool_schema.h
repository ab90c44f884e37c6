// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "client/sdk/spool/sqlite.h"

namespace enfilade::client {

// The layout of a spool's file. A new layout gets a new number, and Open brings older files up to it.
constexpr int kSpoolVersion = 3;

// Makes a fresh file a spool, or checks that it is one: FAILED_PRECONDITION where another program's or a newer
// program's, DATA_LOSS where damaged (`check`: looked through as a whole).
absl::Status PrepareSpoolFile(SqliteDatabase& database, const std::string& path, bool check);

// What every connection to a spool is set to.
absl::Status ConfigureConnection(SqliteDatabase& database);

// Of a record's encoded bytes, as the spool keeps it beside them.
std::int64_t Crc(std::string_view bytes);

}  // namespace enfilade::client
