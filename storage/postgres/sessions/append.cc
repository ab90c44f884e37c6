// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/sessions/append.h"

#include <algorithm>
#include <map>
#include <unordered_map>

#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "core/sensor/record_codec.h"
#include "storage/postgres/driver/copy_buffer.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/maps/blob_rows.h"
#include "storage/postgres/sessions/session_growth.h"

namespace enfilade::storage::postgres {
namespace {

// In the order of their ids, so that two writers never wait for each other. NO KEY: mapping, whose rows refer to the
// session, goes on meanwhile.
constexpr Statement kLockSessions{
    "locking sessions",
    "SELECT session_id, delete_time IS NOT NULL, finish_time IS NOT NULL, records_deleted, acknowledged_sequence,"
    " highest_sequence FROM enfilade.sessions WHERE site_id = $1 AND session_id = ANY ($2) ORDER BY session_id"
    " FOR NO KEY UPDATE"};
constexpr Statement kSelectStored{"looking for stored records",
                                  "SELECT sequence, kind, payload FROM enfilade.session_records"
                                  " WHERE site_id = $1 AND session_id = $2 AND sequence = ANY ($3)"};
constexpr Statement kLockBlobs{"looking for blobs",
                               "SELECT sha256, size FROM enfilade.blobs WHERE site_id = $1 AND sha256 = ANY ($2)"
                               " FOR KEY SHARE"};
constexpr Statement kCopyRecords{
    "storing records",
    "COPY enfilade.session_records (site_id, session_id, sequence, time_ns, kind, payload) FROM STDIN (FORMAT binary)"};
constexpr Statement kInsertBlobRefs{"storing records' blobs",
                                    "INSERT INTO enfilade.session_record_blobs (site_id, session_id, sequence, sha256)"
                                    " SELECT $1, u.* FROM unnest($2::text[], $3::bigint[], $4::bytea[]) u"};
// The end of the run of records without a hole behind $3.
constexpr Statement kFindRunEnd{
    "looking for holes",
    "SELECT r.sequence FROM enfilade.session_records r WHERE r.site_id = $1 AND r.session_id = $2 AND r.sequence > $3"
    " AND NOT EXISTS (SELECT FROM enfilade.session_records n WHERE n.site_id = $1 AND n.session_id = $2"
    "   AND n.sequence = r.sequence + 1) ORDER BY r.sequence LIMIT 1"};

// A session while batches are appended to it.
struct Log {
  bool finished = false;
  bool deleted = false;
  bool records_deleted = false;
  std::int64_t stored_highest = 0;  // in the database before this transaction
  SessionGrowth growth;
  std::vector<const sensor::Record*> accepted;  // in this transaction
};

absl::Status ValidateBatch(const RecordBatch& batch) {
  std::int64_t previous = 0;
  for (const sensor::Record& record : batch.records) {
    if (record.sequence <= previous) {
      return RefuseRecord(
          InvalidArgument("sequence {} comes after {}: sequences start at 1 and increase", record.sequence, previous),
          record.sequence);
    }
    previous = record.sequence;
  }
  return ValidateBlobs(batch.blobs);
}

bool SameContent(const sensor::Record& record, std::int16_t stored_kind, std::string_view stored) {
  const sensor::RecordKind kind = sensor::KindOf(record);
  if (static_cast<std::int16_t>(kind) != stored_kind) return false;
  const std::string payload = sensor::EncodePayload(record);
  if (payload == stored) return true;
  // It may have been stored by a program with another layout of the same values.
  const auto decoded = sensor::DecodePayload(record.sequence, kind, stored);
  return decoded.ok() && sensor::EncodePayload(*decoded) == payload;
}

class SiteAppend {
 public:
  SiteAppend(Transaction& transaction, const SiteId& site) : transaction_(transaction), site_(site) {}

  absl::Status Lock(absl::Span<const RecordBatch* const> batches);
  // Nested: outside, the transaction's failure; inside, why this batch is refused.
  absl::StatusOr<absl::StatusOr<AppendResult>> Accept(const RecordBatch& batch);
  absl::Status Write();

  std::int64_t AcknowledgedOf(const SessionId& session) const { return logs_.at(session.value()).growth.acknowledged; }

 private:
  // The records of the batch that are not stored yet; refuses the batch where one differs from the stored one.
  absl::StatusOr<absl::StatusOr<std::vector<const sensor::Record*>>> SelectNew(const RecordBatch& batch,
                                                                               const Log& log);
  absl::StatusOr<absl::Status> CheckBlobs(const RecordBatch& batch, const std::vector<const sensor::Record*>& records);
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

absl::StatusOr<absl::StatusOr<AppendResult>> SiteAppend::Accept(const RecordBatch& batch) {
  using Refused = absl::StatusOr<AppendResult>;
  const auto found = logs_.find(batch.session.value());
  if (found == logs_.end()) return Refused(NotFound("{} does not exist", NameOf(site_, batch.session)));
  Log& log = found->second;
  if (log.deleted) return Refused(FailedPrecondition("{} is deleted", NameOf(site_, batch.session)));
  ENFILADE_ASSIGN_OR_RETURN(const auto records, SelectNew(batch, log));
  if (!records.ok()) return Refused(records.status());
  if (log.finished && !records->empty()) {
    return Refused(FailedPrecondition("{} is finished and takes no new records: {} is new",
                                      NameOf(site_, batch.session), records->front()->sequence));
  }
  ENFILADE_ASSIGN_OR_RETURN(const absl::Status blobs, CheckBlobs(batch, *records));
  if (!blobs.ok()) return Refused(blobs);
  Take(batch, log, *records);
  AppendResult result;
  result.inserted = static_cast<std::int64_t>(records->size());
  result.duplicates = static_cast<std::int64_t>(batch.records.size()) - result.inserted;
  return Refused(result);
}

absl::StatusOr<absl::StatusOr<std::vector<const sensor::Record*>>> SiteAppend::SelectNew(const RecordBatch& batch,
                                                                                         const Log& log) {
  using Refused = absl::StatusOr<std::vector<const sensor::Record*>>;
  std::vector<const sensor::Record*> fresh;
  std::map<std::int64_t, const sensor::Record*> doubtful;
  for (const sensor::Record& record : batch.records) {
    if (record.sequence > log.growth.highest) {
      fresh.push_back(&record);
    } else if (!log.records_deleted) {
      doubtful[record.sequence] = &record;
    }
  }
  if (doubtful.empty()) return Refused(std::move(fresh));

  const auto conflict = [&](std::int64_t sequence) {
    return Refused(RefuseRecord(
        AlreadyExists("record {} of {} is stored with another content", sequence, NameOf(site_, batch.session)),
        sequence));
  };
  for (const sensor::Record* accepted : log.accepted) {
    const auto same = doubtful.find(accepted->sequence);
    if (same == doubtful.end()) continue;
    const auto kind = static_cast<std::int16_t>(sensor::KindOf(*accepted));
    if (!SameContent(*same->second, kind, sensor::EncodePayload(*accepted))) return conflict(accepted->sequence);
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
    const std::int16_t kind = row.Int16();
    const std::string_view payload = row.Bytes();
    ENFILADE_RETURN_IF_ERROR(row.status());
    if (!SameContent(*doubtful.at(sequence), kind, payload)) return conflict(sequence);
    doubtful.erase(sequence);
  }
  // What is left fills holes, in front of what is beyond the log's end.
  std::vector<const sensor::Record*> records;
  for (const auto& [sequence, record] : doubtful) records.push_back(record);
  records.insert(records.end(), fresh.begin(), fresh.end());
  return Refused(std::move(records));
}

absl::StatusOr<absl::Status> SiteAppend::CheckBlobs(const RecordBatch& batch,
                                                    const std::vector<const sensor::Record*>& records) {
  std::unordered_map<std::string_view, std::int64_t> sizes;
  for (const BlobView& blob : batch.blobs) sizes[blob.sha256] = static_cast<std::int64_t>(blob.data.size());
  std::vector<Bytes> wanted;
  for (const sensor::Record* record : records) {
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
  for (const sensor::Record* record : records) {
    const sensor::BlobRef* blob = sensor::FindBlob(*record);
    if (!blob) continue;
    const auto size = sizes.find(blob->sha256);
    if (size == sizes.end()) {
      return RefuseRecord(InvalidArgument("record {}: its blob {} was not sent", record->sequence, ToHex(blob->sha256)),
                          record->sequence);
    }
    if (size->second != blob->size) {
      return RefuseRecord(InvalidArgument("record {}: its blob {} has {} bytes, not {} as the record says",
                                          record->sequence, ToHex(blob->sha256), size->second, blob->size),
                          record->sequence);
    }
  }
  return absl::Status();
}

void SiteAppend::Take(const RecordBatch& batch, Log& log, const std::vector<const sensor::Record*>& records) {
  constexpr std::size_t kRowBytes = 200;  // all but the ranges, about
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
  }
  return transaction_.Commit();
}

// Where a hole was filled, how far the log goes without one is in the table only.
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
  std::vector<absl::StatusOr<AppendResult>> answers(batches.size(), AppendResult{});
  const auto run = [&]() -> absl::Status {
    ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
    SiteAppend append(transaction, site);
    ENFILADE_RETURN_IF_ERROR(append.Lock(batches));
    for (std::size_t i = 0; i < batches.size(); ++i) {
      if (const absl::Status valid = ValidateBatch(*batches[i]); !valid.ok()) {
        answers[i] = valid;
        continue;
      }
      ENFILADE_ASSIGN_OR_RETURN(answers[i], append.Accept(*batches[i]));
    }
    ENFILADE_RETURN_IF_ERROR(append.Write());
    for (std::size_t i = 0; i < batches.size(); ++i) {
      if (answers[i].ok()) answers[i]->acknowledged_sequence = append.AcknowledgedOf(batches[i]->session);
    }
    return absl::OkStatus();
  };
  const absl::Status outcome = run();
  if (!outcome.ok()) {
    for (auto& answer : answers) {
      if (answer.ok()) answer = outcome;
    }
  }
  return answers;
}

}  // namespace enfilade::storage::postgres
