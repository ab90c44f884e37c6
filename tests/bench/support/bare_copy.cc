// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/bare_copy.h"

#include <libpq-fe.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "core/sensor/record_codec.h"
#include "storage/postgres/driver/copy_buffer.h"

namespace enfilade::bench {
namespace {

constexpr char kCreate[] = "CREATE TABLE IF NOT EXISTS bare_records (LIKE enfilade.session_records INCLUDING ALL)";
constexpr char kEmpty[] = "TRUNCATE bare_records";
constexpr char kCopy[] =
    "COPY bare_records (site_id, session_id, sequence, time_ns, kind, payload) FROM STDIN (FORMAT binary)";

std::string_view ToRows(const std::vector<std::string>& sessions, const std::vector<sensor::Record>& records,
                        storage::postgres::CopyBuffer& rows) {
  for (const std::string& session : sessions) {
    for (const sensor::Record& record : records) {
      rows.BeginRow(6);
      rows.Put(std::string_view("bench"));
      rows.Put(std::string_view(session).substr(session.rfind('/') + 1));
      rows.Put(record.sequence);
      rows.Put(sensor::TimeOf(record));
      rows.Put(static_cast<std::int16_t>(sensor::KindOf(record)));
      rows.PutAppended([&](std::string& out) { sensor::AppendPayload(record, out); });
    }
  }
  return rows.Finish();
}

}  // namespace

void BareCopy::Disconnect::operator()(pg_conn* connection) const { PQfinish(connection); }

BareCopy::BareCopy(const std::string& database_url) : connection_(PQconnectdb(database_url.c_str())) {
  Execute(kCreate);
}

double BareCopy::Run(const std::vector<std::string>& sessions, const std::vector<sensor::Record>& records) {
  constexpr std::size_t kPieceBytes = 1U << 20;
  storage::postgres::CopyBuffer buffer;
  const std::string_view rows = ToRows(sessions, records, buffer);
  Execute(kEmpty);
  const auto begin = std::chrono::steady_clock::now();
  Execute(kCopy);
  for (std::size_t offset = 0; offset < rows.size(); offset += kPieceBytes) {
    const std::string_view piece = rows.substr(offset, kPieceBytes);
    PQputCopyData(connection_.get(), piece.data(), static_cast<int>(piece.size()));
  }
  PQputCopyEnd(connection_.get(), nullptr);
  bool stored = true;
  while (PGresult* result = PQgetResult(connection_.get())) {
    stored = stored && PQresultStatus(result) == PGRES_COMMAND_OK;
    PQclear(result);
  }
  if (!stored) throw std::runtime_error(std::string("COPY: ") + PQerrorMessage(connection_.get()));
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void BareCopy::Execute(const char* sql) {
  PGresult* result = PQexec(connection_.get(), sql);
  const ExecStatusType status = PQresultStatus(result);
  PQclear(result);
  if (status != PGRES_COMMAND_OK && status != PGRES_COPY_IN) {
    throw std::runtime_error(std::string(sql) + ": " + PQerrorMessage(connection_.get()));
  }
}

}  // namespace enfilade::bench
