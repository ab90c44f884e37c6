// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/append_to_site.h"

#include <algorithm>
#include <map>
#include <unordered_map>

#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "core/sensor/record_codec.h"
#include "storage/postgres/driver/copy_buffer.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/maps/blob_store.h"
#include "storage/postgres/sessions/mapping_work.h"
#include "storage/postgres/sessions/session_row.h"
#include "storage/sessions/session_growth.h"

namespace enfilade::storage::postgres {
namespace {

// In the order of their ids, so that two writers never wait for each other. NO KEY: mapping, whose rows refer to the
// session, is not blocked.
constexpr Statement kLockSessions{
    "locking sessions",
    "SELECT session_id, delete_time IS NOT NULL, finish_time IS NOT NULL, records_deleted,"
    " coalesce(recorded_sequence, acknowledged_sequence), coalesce(recorded_sequence, highest_sequence)"
    " FROM enfilade.sessions WHERE site_id = $1 AND session_id = ANY ($2) ORDER BY session_id"
    " FOR NO KEY UPDATE"};
// Also among those that belong to the rest of a session that was cut since.
constexpr Statement kSelectStored{
    "looking for stored records",
    "SELECT sequence, kind, payload FROM enfilade.session_records WHERE site_id = $1 AND session_id IN (SELECT $2::text"
    "   UNION ALL SELECT session_id FROM enfilade.sessions WHERE site_id = $1 AND cut_from_session_id = $2)"
    " AND sequence = ANY ($3)"};
constexpr Statement kLockBlobs{"looking for blobs",
                               "SELECT sha256, size FROM enfilade.blobs WHERE site_id = $1 AND sha256 = ANY ($2)"
                               " FOR KEY SHARE"};
constexpr Statement kCopyRecords{
    "storing records",
    "COPY enfilade.session_records (site_id, session_id, sequence, time_ns, kind, payload) FROM STDIN (FORMAT binary)"};
constexpr Statement kInsertBlobRefs{"storing records' blobs",
                                    "INSERT INTO enfilade.session_record_blobs (site_id, session_id, sequence, sha256)"
                                    " SELECT $1, u.* FROM unnest($2::text[], $3::bigint[], $4::bytea[]) u"};
// The last record of the run without holes after $3.
constexpr Statement kFindRunEnd{
    "looking for holes",
    "SELECT r.sequence FROM enfilade.session_records r WHERE r.site_id = $1 AND r.session_id = $2 AND r.sequence > $3"
    " AND NOT EXISTS (SELECT FROM enfilade.session_records n WHERE n.site_id = $1 AND n.session_id = $2"
    "   AND n.sequence = r.sequence + 1) ORDER BY r.sequence LIMIT 1"};

// The state of a session while batches are appended to it.
struct Log {
  bool finished = false;
  bool deleted = false;
  bool records_deleted = false;
  std::int64_t stored_highest = 0;  // in the database before this transaction
  SessionGrowth growth;
  std::vector<const sensor::Record*> accepted;  // in this transaction
};

using RecordsBySequence = std::map<std::int64_t, const sensor::Record*>;

// What is done with a batch. An error of the transaction is not part of it: that concerns all batches.
struct BatchDecision {
  absl::Status refusal;                      // OK: the batch is accepted
  std::vector<const sensor::Record*> fresh;  // its records that are not stored yet
};

class SiteAppend {
 public:
  SiteAppend(Transaction& transaction, const SiteId& site) : transaction_(transaction), site_(site) {}

  // These fail with the transaction.
  absl::Status Lock(absl::Span<const RecordBatch* const> batches);
  // Queues what is new in the batch for Write, unless the batch is refused.
  absl::StatusOr<BatchDecision> Accept(const RecordBatch& batch);
  absl::Status Write();

  std::int64_t AcknowledgedOf(const SessionId& session) const { return logs_.at(session.value()).growth.acknowledged; }

 private:
  // Refused if a record differs from the stored one.
  absl::StatusOr<BatchDecision> SelectFresh(const RecordBatch& batch, const Log& log);
  // Removes the stored records from `doubtful`. Sets `refusal` if one differs from the stored one.
  absl::Status RemoveStored(const RecordBatch& batch, const Log& log, RecordsBySequence& doubtful,
                            absl::Status& refusal);
  // Sets decision.refusal if the blob of a fresh record is missing or has another size.
  absl::Status CheckBlobs(const RecordBatch& batch, BatchDecision& decision);
  void Take(const RecordBatch& batch, Log& log, const std::vector<const sensor::Record*>& records);
  absl::Status AdvanceAcknowledged();

  Transaction& transaction_;
  const SiteId& site_;
  std::map<std::string, Log> logs_;
  CopyBuffer rows_;
  std::vector<BlobView> blobs_;
  std::vector<std::string_view> ref_sessions_;
  std::vector<std::int64_t> ref_sequences_;
  std::vector<Bytes> ref_blobs_;
};

absl::Status SiteAppend::Lock(absl::Span<const RecordBatch* const> batches) {
  std::vector<std::string_view> ids;
  for (const RecordBatch* batch : batches) ids.push_back(batch->session.value());
  ENFILADE_ASSIGN_OR_RETURN(const Result result, transaction_.Execute(kLockSessions, Params(site_, ids)));
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    Log& log = logs_[std::string(row.Text())];
    log.deleted = row.Bool();
    log.finished = row.Bool();
    log.records_deleted = row.Bool();
    log.growth.acknowledged = row.Int64();
    log.growth.highest = log.stored_highest = row.Int64();
    ENFILADE_RETURN_IF_ERROR(row.status());
  }
  return absl::OkStatus();
}

absl::StatusOr<BatchDecision> SiteAppend::Accept(const RecordBatch& batch) {
  if (absl::Status valid = ValidateBatch(batch); !valid.ok()) return BatchDecision{std::move(valid), {}};
  const auto found = logs_.find(batch.session.value());
  if (found == logs_.end()) return BatchDecision{NotFound("{} does not exist", NameOf(site_, batch.session)), {}};
  Log& log = found->second;
  if (log.deleted) return BatchDecision{FailedPrecondition("{} is deleted", NameOf(site_, batch.session)), {}};
  ENFILADE_ASSIGN_OR_RETURN(BatchDecision decision, SelectFresh(batch, log));
  if (!decision.refusal.ok()) return decision;
  if (log.finished && !decision.fresh.empty()) {
    decision.refusal = FailedPrecondition("{} is finished and takes no new records: {} is new",
                                          NameOf(site_, batch.session), decision.fresh.front()->sequence);
    return decision;
  }
  decision.refusal = ValidateDistance(decision.fresh, log.growth.acknowledged);
  if (!decision.refusal.ok()) return decision;
  ENFILADE_RETURN_IF_ERROR(CheckBlobs(batch, decision));
  if (decision.refusal.ok()) Take(batch, log, decision.fresh);
  return decision;
}

absl::StatusOr<BatchDecision> SiteAppend::SelectFresh(const RecordBatch& batch, const Log& log) {
  std::vector<const sensor::Record*> beyond;  // the end of the log
  RecordsBySequence doubtful;
  for (const sensor::Record& record : batch.records) {
    if (record.sequence > log.growth.highest) {
      beyond.push_back(&record);
    } else if (!log.records_deleted) {
      doubtful[record.sequence] = &record;
    }
  }
  BatchDecision decision;
  if (!doubtful.empty()) ENFILADE_RETURN_IF_ERROR(RemoveStored(batch, log, doubtful, decision.refusal));
  // The rest of them fills holes before the end of the log.
  for (const auto& [sequence, record] : doubtful) decision.fresh.push_back(record);
  decision.fresh.insert(decision.fresh.end(), beyond.begin(), beyond.end());
  return decision;
}

absl::Status SiteAppend::RemoveStored(const RecordBatch& batch, const Log& log, RecordsBySequence& doubtful,
                                      absl::Status& refusal) {
  const auto refuse = [&](std::int64_t sequence) {
    refusal = RefuseRecord(
        AlreadyExists("record {} of {} is stored with other content", sequence, NameOf(site_, batch.session)),
        sequence);
    return absl::OkStatus();
  };
  for (const sensor::Record* accepted : log.accepted) {
    const auto same = doubtful.find(accepted->sequence);
    if (same == doubtful.end()) continue;
    if (!HasContent(*same->second, sensor::KindOf(*accepted), sensor::EncodePayload(*accepted))) {
      return refuse(accepted->sequence);
    }
    doubtful.erase(same);
  }
  std::vector<std::int64_t> sequences;
  for (const auto& [sequence, record] : doubtful) {
    if (sequence <= log.stored_highest) sequences.push_back(sequence);
  }
  ENFILADE_ASSIGN_OR_RETURN(const Result stored,
                            transaction_.Execute(kSelectStored, Params(site_, batch.session, sequences)));
  for (int i = 0; i < stored.rows(); ++i) {
    Row row(stored, i);
    const std::int64_t sequence = row.Int64();
    const auto kind = static_cast<sensor::RecordKind>(row.Int16());
    const std::string_view payload = row.Bytes();
    ENFILADE_RETURN_IF_ERROR(row.status());
    if (!HasContent(*doubtful.at(sequence), kind, payload)) return refuse(sequence);
    doubtful.erase(sequence);
  }
  return absl::OkStatus();
}

absl::Status SiteAppend::CheckBlobs(const RecordBatch& batch, BatchDecision& decision) {
  std::unordered_map<std::string_view, std::int64_t> sizes;
  for (const BlobView& blob : batch.blobs) sizes[blob.sha256] = static_cast<std::int64_t>(blob.data.size());
  std::vector<Bytes> wanted;
  for (const sensor::Record* record : decision.fresh) {
    const sensor::BlobRef* blob = sensor::FindBlob(*record);
    if (blob && !sizes.contains(blob->sha256)) wanted.push_back(Bytes{blob->sha256});
  }
  std::optional<Result> stored;  // holds the digests that `sizes` refers to
  if (!wanted.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(stored, transaction_.Execute(kLockBlobs, Params(site_, wanted)));
    for (int i = 0; i < stored->rows(); ++i) {
      Row row(*stored, i);
      const std::string_view sha256 = row.Bytes();
      sizes[sha256] = row.Int64();
      ENFILADE_RETURN_IF_ERROR(row.status());
    }
  }
  for (const sensor::Record* record : decision.fresh) {
    const sensor::BlobRef* blob = sensor::FindBlob(*record);
    if (!blob) continue;
    const auto size = sizes.find(blob->sha256);
    decision.refusal = ValidateBlobSize(*record, *blob, size == sizes.end() ? 0 : size->second);
    if (!decision.refusal.ok()) break;
  }
  return absl::OkStatus();
}

void SiteAppend::Take(const RecordBatch& batch, Log& log, const std::vector<const sensor::Record*>& records) {
  constexpr std::size_t kRowBytes = 200;  // about what a row has besides the ranges
  for (const sensor::Record* record : records) {
    const auto* scan = std::get_if<sensor::LaserScan>(&record->payload);
    rows_.Reserve(kRowBytes + (scan ? scan->ranges.size() * sizeof(float) : 0));
    rows_.BeginRow(6);
    rows_.Put(site_.value());
    rows_.Put(batch.session.value());
    rows_.Put(record->sequence);
    rows_.Put(sensor::TimeOf(*record));
    rows_.Put(static_cast<std::int16_t>(sensor::KindOf(*record)));
    const std::size_t bytes = rows_.PutAppended([&](std::string& out) { sensor::AppendPayload(*record, out); });
    log.growth.Add(*record, static_cast<std::int64_t>(bytes));
    if (const sensor::BlobRef* blob = sensor::FindBlob(*record)) {
      ref_sessions_.push_back(batch.session.value());
      ref_sequences_.push_back(record->sequence);
      ref_blobs_.push_back(Bytes{blob->sha256});
    }
  }
  log.accepted.insert(log.accepted.end(), records.begin(), records.end());
  blobs_.insert(blobs_.end(), batch.blobs.begin(), batch.blobs.end());
}

absl::Status SiteAppend::Write() {
  QueueBlobs(transaction_, site_, blobs_);
  std::vector<std::pair<std::string_view, const SessionGrowth*>> growths;
  for (const auto& [session, log] : logs_) {
    if (!log.accepted.empty()) growths.emplace_back(session, &log.growth);
  }
  if (!growths.empty()) {
    ENFILADE_RETURN_IF_ERROR(transaction_.CopyIn(kCopyRecords, rows_.Finish()));
    if (!ref_blobs_.empty()) {
      transaction_.Queue(kInsertBlobRefs, Params(site_, ref_sessions_, ref_sequences_, ref_blobs_));
    }
    ENFILADE_RETURN_IF_ERROR(AdvanceAcknowledged());
    QueueGrowth(transaction_, site_, growths);
    std::vector<std::string_view> sessions;
    for (const auto& [session, growth] : growths) sessions.push_back(session);
    QueueMappingWork(transaction_, site_, sessions);
  }
  return transaction_.Commit();
}

// If a hole was filled, the position of the next one is only in the table.
absl::Status SiteAppend::AdvanceAcknowledged() {
  for (auto& [session, log] : logs_) {
    if (!log.growth.filled_hole) continue;
    ENFILADE_ASSIGN_OR_RETURN(const Result result,
                              transaction_.Execute(kFindRunEnd, Params(site_, session, log.growth.acknowledged)));
    ENFILADE_ASSIGN_OR_RETURN(log.growth.acknowledged,
                              ReadOne(
                                  result, [](Row& row) { return row.Int64(); }, "the end of the log"));
  }
  return absl::OkStatus();
}

}  // namespace

std::vector<absl::StatusOr<AppendResult>> AppendToSite(Pool& pool, const CallContext& context, const SiteId& site,
                                                       absl::Span<const RecordBatch* const> batches) {
  std::vector<absl::StatusOr<AppendResult>> results(batches.size(), AppendResult{});
  const auto run = [&]() -> absl::Status {
    ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
    SiteAppend append(transaction, site);
    ENFILADE_RETURN_IF_ERROR(append.Lock(batches));
    for (std::size_t i = 0; i < batches.size(); ++i) {
      ENFILADE_ASSIGN_OR_RETURN(const BatchDecision decision, append.Accept(*batches[i]));
      if (!decision.refusal.ok()) {
        results[i] = decision.refusal;
        continue;
      }
      results[i]->inserted = static_cast<std::int64_t>(decision.fresh.size());
      results[i]->duplicates = static_cast<std::int64_t>(batches[i]->records.size()) - results[i]->inserted;
    }
    ENFILADE_RETURN_IF_ERROR(append.Write());
    for (std::size_t i = 0; i < batches.size(); ++i) {
      if (results[i].ok()) results[i]->acknowledged_sequence = append.AcknowledgedOf(batches[i]->session);
    }
    return absl::OkStatus();
  };
  const absl::Status outcome = run();
  if (!outcome.ok()) {
    for (auto& result : results) {
      if (result.ok()) result = outcome;
    }
  }
  return results;
}

}  // namespace enfilade::storage::postgres
