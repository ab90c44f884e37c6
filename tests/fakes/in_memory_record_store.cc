// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "core/sensor/record_codec.h"
#include "storage/sessions/session_growth.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/fakes/session_rows.h"

namespace enfilade::testing {
namespace {

std::int64_t BlobSize(const SiteRows& site, const storage::RecordBatch& batch, const std::string& sha256) {
  for (const storage::BlobView& blob : batch.blobs) {
    if (blob.sha256 == sha256) return static_cast<std::int64_t>(blob.data.size());
  }
  const auto found = site.blobs.find(sha256);
  return found == site.blobs.end() ? 0 : static_cast<std::int64_t>(found->second.size());
}

// The log of the session as it was recorded, of which it has the first part: with the rests that were cut off.
const RecordRow* FindRecorded(const SiteRows& site, const SessionId& session, std::int64_t sequence) {
  for (const auto& [id, row] : site.sessions) {
    if ((id != session && row.cut_from != session) || row.deleted) continue;
    if (const auto found = row.records.find(sequence); found != row.records.end()) return &found->second;
  }
  return nullptr;
}

// The records of the batch that are not stored yet: first those before the end of the log.
absl::StatusOr<std::vector<const sensor::Record*>> SelectFresh(const SiteRows& site, const SessionRow& row,
                                                               const storage::RecordBatch& batch) {
  std::vector<const sensor::Record*> fresh;
  for (const sensor::Record& record : batch.records) {
    const bool beyond = record.sequence > row.session.highest_sequence;
    if (!beyond && row.session.records_deleted) continue;
    const RecordRow* const stored = FindRecorded(site, batch.session, record.sequence);
    if (stored == nullptr) {
      fresh.push_back(&record);
    } else if (!storage::HasContent(record, stored->kind, stored->payload)) {
      return storage::RefuseRecord(AlreadyExists("record {} of {} is stored with other content", record.sequence,
                                                 NameOf(batch.site, batch.session)),
                                   record.sequence);
    }
  }
  if (row.session.finish_time && !fresh.empty()) {
    return FailedPrecondition("{} is finished and takes no new records: {} is new", NameOf(batch.site, batch.session),
                              fresh.front()->sequence);
  }
  ENFILADE_RETURN_IF_ERROR(storage::ValidateDistance(fresh, row.session.acknowledged_sequence));
  for (const sensor::Record* record : fresh) {
    const sensor::BlobRef* blob = sensor::FindBlob(*record);
    if (blob == nullptr) continue;
    ENFILADE_RETURN_IF_ERROR(storage::ValidateBlobSize(*record, *blob, BlobSize(site, batch, blob->sha256)));
  }
  return fresh;
}

void Grow(SessionRow& row, const storage::SessionGrowth& growth) {
  storage::Session& session = row.session;
  session.highest_sequence = growth.highest;
  session.acknowledged_sequence = growth.acknowledged;
  while (row.records.contains(session.acknowledged_sequence + 1)) ++session.acknowledged_sequence;
  storage::RecordCounts& counts = session.record_counts;
  counts.laser_scans += growth.counts.laser_scans;
  counts.odometry += growth.counts.odometry;
  counts.images += growth.counts.images;
  counts.point_clouds += growth.counts.point_clouds;
  counts.withheld += growth.counts.withheld;
  counts.door_reports += growth.counts.door_reports;
  session.payload_bytes += growth.payload_bytes;
  if (growth.first_time)
    session.first_time = std::min(session.first_time.value_or(*growth.first_time), *growth.first_time);
  if (growth.last_time) session.last_time = std::max(session.last_time.value_or(*growth.last_time), *growth.last_time);
}

// Null if there is no such session, deleted ones included.
SessionRow* FindLog(InMemoryDatabase::Access& access, const SiteId& site, const SessionId& session) {
  SiteRows* const rows = access.FindSite(site);
  if (rows == nullptr) return nullptr;
  const auto found = rows->sessions.find(session);
  return found == rows->sessions.end() ? nullptr : &found->second;
}

// As the robot knows the log.
std::int64_t AcknowledgedOf(const SessionRow& row) {
  return row.recorded_sequence.value_or(row.session.acknowledged_sequence);
}

absl::StatusOr<storage::AppendResult> AppendBatch(InMemoryDatabase::Access& access, const storage::RecordBatch& batch) {
  ENFILADE_RETURN_IF_ERROR(storage::ValidateBatch(batch));
  SessionRow* const found = FindLog(access, batch.site, batch.session);
  if (found == nullptr) return NotFound("{} does not exist", NameOf(batch.site, batch.session));
  SiteRows* const site = access.FindSite(batch.site);
  SessionRow& row = *found;
  if (row.deleted) return FailedPrecondition("{} is deleted", NameOf(batch.site, batch.session));
  ENFILADE_ASSIGN_OR_RETURN(const auto fresh, SelectFresh(*site, row, batch));
  for (const storage::BlobView& blob : batch.blobs) site->blobs[std::string(blob.sha256)] = blob.data;
  storage::SessionGrowth growth;
  growth.acknowledged = row.session.acknowledged_sequence;
  growth.highest = row.session.highest_sequence;
  for (const sensor::Record* record : fresh) {
    std::string payload = sensor::EncodePayload(*record);
    growth.Add(*record, static_cast<std::int64_t>(payload.size()));
    row.records[record->sequence] = {sensor::KindOf(*record), sensor::TimeOf(*record), std::move(payload)};
  }
  if (!fresh.empty()) {
    Grow(row, growth);
    row.append_time = access.Now();
    QueueWork(row, access.Now());
  }
  const auto inserted = static_cast<std::int64_t>(fresh.size());
  return storage::AppendResult{AcknowledgedOf(row), inserted,
                               static_cast<std::int64_t>(batch.records.size()) - inserted};
}

absl::StatusOr<sensor::Record> Decode(const SiteId& site, const SessionId& session, std::int64_t sequence,
                                      const RecordRow& row) {
  auto record = sensor::DecodePayload(sequence, row.kind, row.payload);
  if (!record.ok()) return WithContext(record.status(), NameOf(site, session));
  return record;
}

}  // namespace

std::vector<absl::StatusOr<storage::AppendResult>> InMemoryRecordStore::AppendGroup(
    const storage::CallContext& context, absl::Span<const storage::RecordBatch> batches) const {
  std::vector<absl::StatusOr<storage::AppendResult>> results;
  auto access = database_.Open(context);
  for (const storage::RecordBatch& batch : batches) {
    if (access.ok()) {
      results.push_back(AppendBatch(*access, batch));
    } else {
      results.emplace_back(access.status());
    }
  }
  // As all batches of a site are one transaction, each learns of the whole log.
  for (std::size_t i = 0; i < batches.size(); ++i) {
    if (!results[i].ok()) continue;
    results[i]->acknowledged_sequence = AcknowledgedOf(*FindLog(*access, batches[i].site, batches[i].session));
  }
  return results;
}

absl::StatusOr<std::vector<sensor::Record>> InMemoryRecordStore::Read(const storage::CallContext& context,
                                                                      const SiteId& site, const SessionId& session,
                                                                      std::int64_t from_sequence,
                                                                      std::int64_t max_bytes) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  ENFILADE_ASSIGN_OR_RETURN(const SessionRow* const row, access.GetSession(site, session));
  if (row->session.records_deleted) {
    return FailedPrecondition("the records of {} were deleted at the end of the site's retention",
                              NameOf(site, session));
  }
  std::vector<sensor::Record> records;
  std::int64_t bytes = 0;
  for (auto stored = row->records.lower_bound(from_sequence); stored != row->records.end(); ++stored) {
    if (stored->first > row->session.acknowledged_sequence || bytes >= max_bytes) break;
    ENFILADE_ASSIGN_OR_RETURN(sensor::Record record, Decode(site, session, stored->first, stored->second));
    records.push_back(std::move(record));
    bytes += static_cast<std::int64_t>(stored->second.payload.size());
  }
  return records;
}

absl::StatusOr<std::vector<sensor::Record>> InMemoryRecordStore::ReadSelected(
    const storage::CallContext& context, const SiteId& site, const SessionId& session,
    const storage::RecordSelection& selection) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<sensor::Record> records;
  const SessionRow* const row = FindLog(access, site, session);
  if (row == nullptr) return records;
  for (const auto& [sequence, stored] : row->records) {
    if (sequence < selection.first_sequence || sequence > selection.last_sequence) continue;
    if (stored.time < selection.from_time || stored.time > selection.to_time) continue;
    if (std::find(selection.kinds.begin(), selection.kinds.end(), stored.kind) == selection.kinds.end()) continue;
    ENFILADE_ASSIGN_OR_RETURN(sensor::Record record, Decode(site, session, sequence, stored));
    records.push_back(std::move(record));
  }
  return records;
}

absl::StatusOr<std::vector<sensor::Record>> InMemoryRecordStore::ReadEach(
    const storage::CallContext& context, const SiteId& site, const SessionId& session,
    const std::vector<std::int64_t>& sequences) const {
  ENFILADE_ASSIGN_OR_RETURN(auto access, database_.Open(context));
  std::vector<sensor::Record> records;
  const SessionRow* const row = FindLog(access, site, session);
  if (row == nullptr) return records;
  for (const std::int64_t sequence : std::set<std::int64_t>(sequences.begin(), sequences.end())) {
    const auto stored = row->records.find(sequence);
    if (stored == row->records.end()) continue;
    ENFILADE_ASSIGN_OR_RETURN(sensor::Record record, Decode(site, session, sequence, stored->second));
    records.push_back(std::move(record));
  }
  return records;
}

}  // namespace enfilade::testing
