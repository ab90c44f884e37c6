// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/error.h"

#include <libpq-fe.h>

#include <array>

#include "core/base/error.h"

namespace enfilade::storage::postgres {
namespace {

constexpr char kSqlStatePayload[] = "enfilade/sqlstate";
constexpr char kConstraintPayload[] = "enfilade/constraint";
constexpr char kDatabaseTextPayload[] = "enfilade/database";
// What a trigger refuses in sites that are being deleted.
constexpr char kSiteIsBeingDeleted[] = "site_is_being_deleted";

struct CodeOfState {
  std::string_view prefix;
  absl::StatusCode code;
};

// The first matching prefix counts.
constexpr std::array kCodes = {
    CodeOfState{"40001", absl::StatusCode::kAborted},  // serialization_failure
    CodeOfState{"40P01", absl::StatusCode::kAborted},  // deadlock_detected
    CodeOfState{"55P03", absl::StatusCode::kAborted},  // lock_not_available
    CodeOfState{"23505", absl::StatusCode::kAlreadyExists}, CodeOfState{"23503", absl::StatusCode::kFailedPrecondition},
    CodeOfState{"23502", absl::StatusCode::kInvalidArgument},     // not_null_violation
    CodeOfState{"23514", absl::StatusCode::kInvalidArgument},     // check_violation
    CodeOfState{"22", absl::StatusCode::kInvalidArgument},        // data_exception
    CodeOfState{"55000", absl::StatusCode::kFailedPrecondition},  // object_not_in_prerequisite_state
    CodeOfState{"57014", absl::StatusCode::kDeadlineExceeded},
    CodeOfState{"57P", absl::StatusCode::kUnavailable},       // shutdown, crash, starting up
    CodeOfState{"53300", absl::StatusCode::kUnavailable},     // too_many_connections
    CodeOfState{"53", absl::StatusCode::kResourceExhausted},  // disk_full, out_of_memory
    CodeOfState{"54", absl::StatusCode::kResourceExhausted},  // program_limit_exceeded
    CodeOfState{"25006", absl::StatusCode::kUnavailable},     // read_only_sql_transaction: a standby
    CodeOfState{"25P03", absl::StatusCode::kUnavailable},     // idle_in_transaction_session_timeout
    CodeOfState{"0A000", absl::StatusCode::kUnavailable},     // a plan from before a migration
    CodeOfState{"26000", absl::StatusCode::kUnavailable},     // a prepared statement is missing: a pooler in between
    CodeOfState{"08", absl::StatusCode::kUnavailable},
    // The server's own fault, which an operator mends: no fault of the caller, who may try again.
    CodeOfState{"42501", absl::StatusCode::kUnavailable},  // insufficient_privilege
    CodeOfState{"28", absl::StatusCode::kUnavailable},     // invalid_authorization_specification
    CodeOfState{"42P01", absl::StatusCode::kUnavailable},  // undefined_table: not migrated
    CodeOfState{"42703", absl::StatusCode::kUnavailable},  // undefined_column
    CodeOfState{"42883", absl::StatusCode::kUnavailable},  // undefined_function
    CodeOfState{"42704", absl::StatusCode::kUnavailable},  // undefined_object
    CodeOfState{"3F000", absl::StatusCode::kUnavailable},  // invalid_schema_name
    CodeOfState{"3D000", absl::StatusCode::kUnavailable},  // invalid_catalog_name
};

std::string Field(const pg_result* result, int field) {
  const char* text = PQresultErrorField(result, field);
  return text ? text : "";
}

std::string PayloadOf(const absl::Status& status, const char* url) {
  const auto payload = status.GetPayload(url);
  return payload ? std::string(*payload) : std::string();
}

std::string WithoutLineEnd(const char* text) {
  std::string result = text ? text : "";
  while (!result.empty() && result.back() == '\n') result.pop_back();
  return result;
}

// Constraints of a shard are named after those of the whole table: sessions_pkey_102041.
std::string WithoutShard(std::string constraint) {
  const std::size_t end = constraint.find_last_not_of("0123456789");
  const bool has_shard = end != std::string::npos && end + 1 < constraint.size() && constraint[end] == '_';
  return has_shard ? constraint.substr(0, end) : constraint;
}

// What the database or libpq says may name hosts, users and rows: it is for the log (ToString), not for callers.
absl::Status WithDatabaseText(absl::Status status, const std::string& text) {
  status.SetPayload(kDatabaseTextPayload, absl::Cord(text));
  return status;
}

}  // namespace

absl::StatusCode CodeOfSqlState(std::string_view sqlstate) {
  for (const CodeOfState& entry : kCodes) {
    if (sqlstate.starts_with(entry.prefix)) return entry.code;
  }
  return absl::StatusCode::kInternal;
}

absl::Status StatusFromResult(const pg_result* result, std::string_view what) {
  const std::string sqlstate = Field(result, PG_DIAG_SQLSTATE);
  const std::string constraint = WithoutShard(Field(result, PG_DIAG_CONSTRAINT_NAME));
  if (sqlstate.empty()) {  // made by libpq
    return WithDatabaseText(Unavailable("{}: the database does not answer", what),
                            WithoutLineEnd(PQresultErrorMessage(result)));
  }
  std::string message = fmt::format("{}: the database refused it (SQLSTATE {})", what, sqlstate);
  if (!constraint.empty()) message += ", by the constraint " + constraint;
  if (constraint == kSiteIsBeingDeleted) message = fmt::format("{}: the site is being deleted", what);
  std::string text = Field(result, PG_DIAG_MESSAGE_PRIMARY);
  if (const std::string detail = Field(result, PG_DIAG_MESSAGE_DETAIL); !detail.empty()) text += ": " + detail;
  absl::Status status = WithDatabaseText(absl::Status(CodeOfSqlState(sqlstate), message), text);
  status.SetPayload(kSqlStatePayload, absl::Cord(sqlstate));
  if (!constraint.empty()) status.SetPayload(kConstraintPayload, absl::Cord(constraint));
  return status;
}

absl::Status LostConnection(const pg_conn* connection, std::string_view what) {
  return WithDatabaseText(Unavailable("{}: the connection to the database was lost", what),
                          WithoutLineEnd(PQerrorMessage(connection)));
}

absl::Status CannotConnect(const pg_conn* connection) {
  return WithDatabaseText(Unavailable("cannot connect to the database"), WithoutLineEnd(PQerrorMessage(connection)));
}

std::string SqlStateOf(const absl::Status& status) { return PayloadOf(status, kSqlStatePayload); }
std::string ConstraintOf(const absl::Status& status) { return PayloadOf(status, kConstraintPayload); }
std::string DatabaseTextOf(const absl::Status& status) { return PayloadOf(status, kDatabaseTextPayload); }

}  // namespace enfilade::storage::postgres
