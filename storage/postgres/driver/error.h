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
// RESOURCE_EXHAUSTED; class 08, 57P01..5, 53300, 25006 -> UNAVAILABLE; 42501, class 28 -> PERMISSION_DENIED; 42P01,
// 3F000, 3D000 -> FAILED_PRECONDITION (not migrated); else INTERNAL.
absl::StatusCode CodeOfSqlState(std::string_view sqlstate);

// The error of a failed result: "<what>: <server's message>", with detail, SQLSTATE and constraint. `what` names the
// operation. UNAVAILABLE if the connection was lost.
absl::Status StatusFromResult(const pg_result* result, std::string_view what);

// UNAVAILABLE with libpq's message, for a lost connection.
absl::Status LostConnection(const pg_conn* connection, std::string_view what);

// From an error made by StatusFromResult; empty otherwise.
std::string SqlStateOf(const absl::Status& status);
std::string ConstraintOf(const absl::Status& status);

}  // namespace enfilade::storage::postgres
