// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/base/ids.h"
#include "core/sensor/record.h"
#include "storage/blob_store.h"
#include "storage/call_context.h"

namespace enfilade::storage {
namespace postgres {
class Pool;
}

// Records of one session, in strictly increasing order of sequence. The referred values must live until the call
// returns.
struct RecordBatch {
  const SiteId& site;
  const SessionId& session;
  absl::Span<const sensor::Record> records;
  // Blobs that the records refer to and that may not be stored yet.
  absl::Span<const BlobView> blobs;
};

// Some records of a log: all of this must hold.
struct RecordSelection {
  std::vector<sensor::RecordKind> kinds;
  TimeNs from_time = 0;  // both included
  TimeNs to_time = 0;
  std::int64_t first_sequence = 0;  // both included; few thousands apart, as all between are looked at
  std::int64_t last_sequence = 0;
};

struct AppendResult {
  std::int64_t acknowledged_sequence = 0;  // all records up to it are stored
  std::int64_t inserted = 0;
  std::int64_t duplicates = 0;  // were stored already, with the same content
};

// The sequence of the record at fault where Append refused a batch for one record, 0 otherwise.
std::int64_t RefusedSequenceOf(const absl::Status& status);

// The log of sessions. Thread-safe; errors common to all stores: see SiteStore.
class RecordStore {
 public:
  explicit RecordStore(postgres::Pool& pool) : pool_(pool) {}

  // Stores the batch, all or nothing; when it returns OK everything is committed and survives any crash. Idempotent on
  // (session, sequence). Sequences may come in any order: what is beyond a hole counts as acknowledged when the hole
  // is filled.
  //
  // NOT_FOUND: no such session. FAILED_PRECONDITION: the session is deleted, or finished and something in the batch is
  // new to it. For one record, told by message and RefusedSequenceOf: ALREADY_EXISTS where another content is stored
  // under its sequence; INVALID_ARGUMENT where its blob is missing or of another size, or its sequence is below 1 or
  // not above the one before. Records count as valid otherwise (Validate(Record) is the caller's).
  absl::StatusOr<AppendResult> Append(const CallContext& context, const RecordBatch& batch) const;

  // Several batches, those of one site in one transaction, for throughput: one answer per batch, in order, each as
  // Append would give it; a refused batch does not touch the others. Several batches of one session are stored in their
  // order.
  std::vector<absl::StatusOr<AppendResult>> AppendGroup(const CallContext& context,
                                                        absl::Span<const RecordBatch> batches) const;

  // The next records from `from_sequence` on without a hole, up to the acknowledged one, of about `max_bytes` of
  // payload together, at least one; empty where there is none yet. NOT_FOUND; FAILED_PRECONDITION where retention has
  // deleted the session's records; DATA_LOSS where a payload does not decode.
  absl::StatusOr<std::vector<sensor::Record>> Read(const CallContext& context, const SiteId& site,
                                                   const SessionId& session, std::int64_t from_sequence,
                                                   std::int64_t max_bytes) const;

  // Those of `selection`, in the order of the log; none where retention has deleted them. DATA_LOSS as in Read.
  absl::StatusOr<std::vector<sensor::Record>> ReadSelected(const CallContext& context, const SiteId& site,
                                                           const SessionId& session,
                                                           const RecordSelection& selection) const;
  // Those of these sequences that are there, in the order of the log. DATA_LOSS as in Read.
  absl::StatusOr<std::vector<sensor::Record>> ReadEach(const CallContext& context, const SiteId& site,
                                                       const SessionId& session,
                                                       const std::vector<std::int64_t>& sequences) const;

 private:
  postgres::Pool& pool_;
};

}  // namespace enfilade::storage
