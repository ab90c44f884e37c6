// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "client/sdk/spool/sqlite.h"

namespace enfilade::client {

// The layout of a spool's file. Spool::Open upgrades older files.
constexpr int kSpoolVersion = 3;

// Creates the tables in a new file, or checks that the file is a spool. FAILED_PRECONDITION: another program's file, or
// a newer layout; DATA_LOSS: damaged. `check`: checks the whole file.
absl::Status PrepareSpoolFile(SqliteDatabase& database, const std::string& path, bool check);

// Sets what every connection to a spool needs: WAL, fsync on commit, foreign keys.
absl::Status ConfigureConnection(SqliteDatabase& database);

// The checksum that the spool stores beside a record's encoded bytes.
std::int64_t Crc(std::string_view bytes);

}  // namespace enfilade::client
