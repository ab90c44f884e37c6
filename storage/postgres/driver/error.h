// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"

struct pg_conn;
struct pg_result;

namespace enfilade::storage::postgres {

// What an SQLSTATE means to callers: 40001, 40P01, 55P03 -> ABORTED (retry); 23505 -> ALREADY_EXISTS; 23503 ->
// FAILED_PRECONDITION; class 22, 23502, 23514 -> INVALID_ARGUMENT; 57014 -> DEADLINE_EXCEEDED; 53100, 53200, 54xxx ->
// RESOURCE_EXHAUSTED; class 08, 57P01..5, 53300, 25006 -> UNAVAILABLE; 42501, class 28 -> PERMISSION_DENIED; 42P01,
// 3F000, 3D000 -> FAILED_PRECONDITION (not migrated); else INTERNAL.
absl::StatusCode CodeOfSqlState(std::string_view sqlstate);

// The error of a failed result: "<what>: <server's message>", with detail, SQLSTATE and constraint. `what` says what
// was being done. Where the connection was lost meanwhile: UNAVAILABLE.
absl::Status StatusFromResult(const pg_result* result, std::string_view what);

// UNAVAILABLE with libpq's own message, for a connection that was lost.
absl::Status LostConnection(const pg_conn* connection, std::string_view what);

// What the server named in an error made by StatusFromResult; empty otherwise.
std::string SqlStateOf(const absl::Status& status);
std::string ConstraintOf(const absl::Status& status);

}  // namespace enfilade::storage::postgres
