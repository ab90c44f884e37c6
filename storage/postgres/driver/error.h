// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"

struct pg_conn;
struct pg_result;

namespace enfilade::storage::postgres {

// The code for an SQLSTATE: 40001, 40P01, 55P03 -> ABORTED (retry); 23505 -> ALREADY_EXISTS; 23503 ->
// FAILED_PRECONDITION; class 22, 23502, 23514 -> INVALID_ARGUMENT; 57014 -> DEADLINE_EXCEEDED; 53100, 53200, 54xxx ->
// RESOURCE_EXHAUSTED; class 08, 57P01..5, 53300, 25006 -> UNAVAILABLE, and likewise what an operator has to mend:
// missing rights (42501, class 28), schema or database (42P01, 42703, 42704, 42883, 3F000, 3D000); else INTERNAL.
absl::StatusCode CodeOfSqlState(std::string_view sqlstate);

// The error of a failed result: `what`, which names the operation, SQLSTATE and constraint. UNAVAILABLE if the
// connection was lost. The database's own words are never part of a message: they are for the log (ToString,
// DatabaseTextOf).
absl::Status StatusFromResult(const pg_result* result, std::string_view what);

// UNAVAILABLE.
absl::Status LostConnection(const pg_conn* connection, std::string_view what);
absl::Status CannotConnect(const pg_conn* connection);

// From an error made by the functions above; empty otherwise.
std::string SqlStateOf(const absl::Status& status);
// The constraint as the migrations name it, also if a shard of the table refused.
std::string ConstraintOf(const absl::Status& status);
std::string DatabaseTextOf(const absl::Status& status);

}  // namespace enfilade::storage::postgres
