// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/record_store.h"

#include <map>

#include "core/base/resource_name.h"
#include "core/sensor/record_codec.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/sessions/append_to_site.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kSelectRetention{
    "reading the session",
    "SELECT records_deleted FROM enfilade.sessions WHERE site_id = $1 AND session_id = $2 AND delete_time IS NULL"};
// Reads as many rows as fit by the session's mean size, and returns those that do fit: it neither reads many rows for
// nothing nor needs many calls.
constexpr Statement kRead{
    "reading records",
    "SELECT sequence, kind, payload FROM ("
    "  SELECT r.*, sum(octet_length(payload)) OVER (ORDER BY sequence) - octet_length(payload) AS bytes_before FROM ("
    "    SELECT sequence, kind, payload FROM enfilade.session_records"
    "    WHERE site_id = $1 AND session_id = $2 AND sequence >= $3 AND sequence <="
    "      (SELECT acknowledged_sequence FROM enfilade.sessions WHERE site_id = $1 AND session_id = $2)"
    "    ORDER BY sequence LIMIT (SELECT 1 + $4 * acknowledged_sequence / (1 + payload_bytes)"
    "      FROM enfilade.sessions WHERE site_id = $1 AND session_id = $2)) r) s"
    " WHERE bytes_before < $4 ORDER BY sequence"};

constexpr Statement kReadSelected{
    "reading selected records",
    "SELECT sequence, kind, payload FROM enfilade.session_records WHERE site_id = $1 AND session_id = $2"
    " AND sequence BETWEEN $3 AND $4 AND kind = ANY ($5) AND time_ns BETWEEN $6 AND $7 ORDER BY sequence"};

constexpr Statement kReadEach{
    "reading single records",
    "SELECT sequence, kind, payload FROM enfilade.session_records WHERE site_id = $1 AND session_id = $2"
    " AND sequence = ANY ($3) ORDER BY sequence"};

absl::StatusOr<std::vector<sensor::Record>> DecodeRecords(const Result& result, const std::string& session) {
  std::vector<sensor::Record> records;
  records.reserve(static_cast<std::size_t>(result.rows()));
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    const std::int64_t sequence = row.Int64();
    const auto kind = static_cast<sensor::RecordKind>(row.Int16());
    const std::string_view payload = row.Bytes();
    ENFILADE_RETURN_IF_ERROR(row.status());
    auto record = sensor::DecodePayload(sequence, kind, payload);
    if (!record.ok()) return WithContext(record.status(), session);
    records.push_back(*std::move(record));
  }
  return records;
}

}  // namespace

std::vector<absl::StatusOr<AppendResult>> RecordStore::AppendGroup(const CallContext& context,
                                                                   absl::Span<const RecordBatch> batches) const {
  std::map<std::string_view, std::vector<std::size_t>> by_site;
  for (std::size_t i = 0; i < batches.size(); ++i) by_site[batches[i].site.value()].push_back(i);
  std::vector<absl::StatusOr<AppendResult>> answers(batches.size());
  for (const auto& [site, indices] : by_site) {
    std::vector<const RecordBatch*> of_site;
    for (const std::size_t i : indices) of_site.push_back(&batches[i]);
    auto site_answers = AppendToSite(pool_, context, of_site.front()->site, of_site);
    for (std::size_t i = 0; i < indices.size(); ++i) answers[indices[i]] = std::move(site_answers[i]);
  }
  return answers;
}

absl::StatusOr<std::vector<sensor::Record>> RecordStore::Read(const CallContext& context, const SiteId& site,
                                                              const SessionId& session, std::int64_t from_sequence,
                                                              std::int64_t max_bytes) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(kRead, Params(site, session, from_sequence, max_bytes));
  transaction.Queue(kSelectRetention, Params(site, session));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  ENFILADE_ASSIGN_OR_RETURN(const bool deleted,
                            ReadOne(
                                results[1], [](Row& row) { return row.Bool(); }, NameOf(site, session)));
  if (deleted) {
    return FailedPrecondition("the records of {} were deleted at the end of the site's retention",
                              NameOf(site, session));
  }
  return DecodeRecords(results[0], NameOf(site, session));
}

absl::StatusOr<std::vector<sensor::Record>> RecordStore::ReadSelected(const CallContext& context, const SiteId& site,
                                                                      const SessionId& session,
                                                                      const RecordSelection& selection) const {
  std::vector<std::int16_t> kinds;
  for (const sensor::RecordKind kind : selection.kinds) kinds.push_back(static_cast<std::int16_t>(kind));
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            ExecuteAlone(pool_, context, kReadSelected,
                                         Params(site, session, selection.first_sequence, selection.last_sequence, kinds,
                                                selection.from_time, selection.to_time)));
  return DecodeRecords(result, NameOf(site, session));
}

absl::StatusOr<std::vector<sensor::Record>> RecordStore::ReadEach(const CallContext& context, const SiteId& site,
                                                                  const SessionId& session,
                                                                  const std::vector<std::int64_t>& sequences) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            ExecuteAlone(pool_, context, kReadEach, Params(site, session, sequences)));
  return DecodeRecords(result, NameOf(site, session));
}

}  // namespace enfilade::storage::postgres
