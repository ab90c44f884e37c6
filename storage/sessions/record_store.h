// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/base/ids.h"
#include "core/sensor/record.h"
#include "storage/call_context.h"
#include "storage/maps/blob_store.h"

namespace enfilade::storage {

// Records of one session, in strictly increasing order of sequence. The referenced values must live until the call
// returns.
struct RecordBatch {
  const SiteId& site;
  const SessionId& session;
  absl::Span<const sensor::Record> records;
  // Blobs that the records refer to and that may not be stored yet.
  absl::Span<const BlobView> blobs;
};

// Selects records of a log. All conditions must hold; limits are inclusive.
struct RecordSelection {
  std::vector<sensor::RecordKind> kinds;
  TimeNs from_time = 0;
  TimeNs to_time = 0;
  std::int64_t first_sequence = 0;  // keep the range to a few thousand: all records in it are read
  std::int64_t last_sequence = 0;
};

struct AppendResult {
  std::int64_t acknowledged_sequence = 0;  // all records up to it are stored
  std::int64_t inserted = 0;
  std::int64_t duplicates = 0;  // were already stored with the same content
};

// INVALID_ARGUMENT unless sequences start at 1 and increase (see RefusedSequenceOf) and the blobs are valid.
absl::Status ValidateBatch(const RecordBatch& batch);

// INVALID_ARGUMENT (see RefusedSequenceOf) unless the blob of `record` is stored with the size that the record gives.
// `stored_size` 0: it is not stored.
absl::Status ValidateBlobSize(const sensor::Record& record, const sensor::BlobRef& blob, std::int64_t stored_size);
// A record may be at most this far beyond the acknowledged one: a hole can then always be filled.
constexpr std::int64_t kMaxSequenceDistance = 1'000'000;
// INVALID_ARGUMENT (see RefusedSequenceOf) if one of `fresh`, by sequence, is more than kMaxSequenceDistance beyond
// `acknowledged`.
absl::Status ValidateDistance(const std::vector<const sensor::Record*>& fresh, std::int64_t acknowledged);
// Whether `kind` and `payload` are those of `record`, also if another layout of the same values is stored.
bool HasContent(const sensor::Record& record, sensor::RecordKind kind, std::string_view payload);

// `status` with the record at fault, for RefusedSequenceOf.
absl::Status RefuseRecord(absl::Status status, std::int64_t sequence);
// The sequence of the record at fault if Append refused a batch because of one record, else 0.
std::int64_t RefusedSequenceOf(const absl::Status& status);

// The logs of sessions. Thread-safe; errors common to all stores: see SiteStore.
class RecordStore {
 public:
  virtual ~RecordStore() = default;

  // Stores the whole batch or nothing. When it returns OK, everything is committed and survives a crash. Idempotent on
  // (session, sequence). Sequences may arrive in any order: records beyond a hole are acknowledged when the hole is
  // filled.
  //
  // NOT_FOUND: no such session. FAILED_PRECONDITION: the session is deleted, or it is finished and the batch has new
  // records. Because of one record, named by the message and RefusedSequenceOf: ALREADY_EXISTS if other content is
  // stored under its sequence; INVALID_ARGUMENT if its blob is missing or has another size, or its sequence is below 1,
  // not above the one before, or more than kMaxSequenceDistance beyond the acknowledged one. Otherwise records are
  // taken as valid: Validate(Record) is up to the caller.
  absl::StatusOr<AppendResult> Append(const CallContext& context, const RecordBatch& batch) const {
    return AppendGroup(context, absl::MakeConstSpan(&batch, 1)).front();
  }

  // Several batches, those of one site in one transaction, for throughput. Returns one result per batch, in order, as
  // Append would; a refused batch does not affect the others. Batches of one session are stored in their order.
  virtual std::vector<absl::StatusOr<AppendResult>> AppendGroup(const CallContext& context,
                                                                absl::Span<const RecordBatch> batches) const = 0;

  // The next records from `from_sequence` up to the acknowledged one: at least one, about `max_bytes` of payload in
  // total. Empty if there are none yet. NOT_FOUND; FAILED_PRECONDITION if retention has deleted the session's records;
  // DATA_LOSS if a payload does not decode.
  virtual absl::StatusOr<std::vector<sensor::Record>> Read(const CallContext& context, const SiteId& site,
                                                           const SessionId& session, std::int64_t from_sequence,
                                                           std::int64_t max_bytes) const = 0;

  // The records of `selection`, in the order of the log; none if retention has deleted them. DATA_LOSS as in Read.
  virtual absl::StatusOr<std::vector<sensor::Record>> ReadSelected(const CallContext& context, const SiteId& site,
                                                                   const SessionId& session,
                                                                   const RecordSelection& selection) const = 0;
  // Those of `sequences` that are stored, in the order of the log. DATA_LOSS as in Read.
  virtual absl::StatusOr<std::vector<sensor::Record>> ReadEach(const CallContext& context, const SiteId& site,
                                                               const SessionId& session,
                                                               const std::vector<std::int64_t>& sequences) const = 0;
};

}  // namespace enfilade::storage
