// SPDX-License-Identifier: Apache-2.0
#include "storage/sessions/record_store.h"

#include <charconv>
#include <string>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/sensor/record_codec.h"

namespace enfilade::storage {
namespace {

constexpr char kRefusedSequencePayload[] = "enfilade/refused_sequence";

}  // namespace

absl::Status RefuseRecord(absl::Status status, std::int64_t sequence) {
  status.SetPayload(kRefusedSequencePayload, absl::Cord(std::to_string(sequence)));
  return status;
}

std::int64_t RefusedSequenceOf(const absl::Status& status) {
  const auto payload = status.GetPayload(kRefusedSequencePayload);
  if (!payload) return 0;
  const std::string text(*payload);
  std::int64_t sequence = 0;
  std::from_chars(text.data(), text.data() + text.size(), sequence);
  return sequence;
}

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

absl::Status ValidateBlobSize(const sensor::Record& record, const sensor::BlobRef& blob, std::int64_t stored_size) {
  if (stored_size == 0) {
    return RefuseRecord(InvalidArgument("record {}: its blob {} was not sent", record.sequence, ToHex(blob.sha256)),
                        record.sequence);
  }
  if (stored_size != blob.size) {
    return RefuseRecord(InvalidArgument("record {}: its blob {} has {} bytes, not {} as the record says",
                                        record.sequence, ToHex(blob.sha256), stored_size, blob.size),
                        record.sequence);
  }
  return absl::OkStatus();
}

absl::Status ValidateDistance(const std::vector<const sensor::Record*>& fresh, std::int64_t acknowledged) {
  for (const sensor::Record* record : fresh) {
    if (record->sequence - acknowledged <= kMaxSequenceDistance) continue;
    return RefuseRecord(InvalidArgument("sequence {} is more than {} beyond the acknowledged {}", record->sequence,
                                        kMaxSequenceDistance, acknowledged),
                        record->sequence);
  }
  return absl::OkStatus();
}

bool HasContent(const sensor::Record& record, sensor::RecordKind kind, std::string_view payload) {
  if (sensor::KindOf(record) != kind) return false;
  const std::string encoded = sensor::EncodePayload(record);
  if (encoded == payload) return true;
  const auto decoded = sensor::DecodePayload(record.sequence, kind, payload);
  return decoded.ok() && sensor::EncodePayload(*decoded) == encoded;
}

}  // namespace enfilade::storage
