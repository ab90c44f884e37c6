// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/ingest/batch.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/record.h"

namespace enfilade::server {
namespace {

Refusal RefuseBatch(const v1::RecordBatch& batch, std::string message) {
  const std::int64_t first = batch.records().empty() ? 0 : batch.records(0).sequence();
  return {first, 0, Refusal::Reason::kInvalidBatch, std::move(message)};
}

}  // namespace

IngestItem ReadBatch(const v1::RecordBatch& batch) {
  if (batch.records().empty()) return RefuseBatch(batch, "the batch has no records");
  if (batch.records_size() > kMaxBatchRecords) {
    return RefuseBatch(batch, fmt::format("the batch has {} records, more than the limit of {}", batch.records_size(),
                                          kMaxBatchRecords));
  }
  if (const std::size_t bytes = batch.ByteSizeLong(); bytes > kMaxBatchBytes && batch.records_size() > 1) {
    return RefuseBatch(batch, fmt::format("the batch has {} bytes, more than the limit of {}", bytes, kMaxBatchBytes));
  }
  IngestBatch items;
  items.records.reserve(static_cast<std::size_t>(batch.records_size()));
  const std::int64_t first = batch.records(0).sequence();
  for (int i = 0; i < batch.records_size(); ++i) {
    const v1::Record& in = batch.records(i);
    if (in.sequence() != first + i) {
      return RefuseBatch(
          batch, fmt::format("record {} of the batch has the sequence {}: sequences must increase by one from {}", i,
                             in.sequence(), first));
    }
    absl::StatusOr<sensor::Record> record = enfilade::convert::FromProto(in);
    if (!record.ok()) {
      return Refusal{first, in.sequence(), Refusal::Reason::kInvalidRecord,
                     fmt::format("record {}: {}", in.sequence(), std::string(record.status().message()))};
    }
    items.records.push_back(*std::move(record));
  }
  return items;
}

absl::StatusOr<bool> BlobAssembly::Add(const v1::BlobChunk& chunk) {
  if (chunk.data().empty() || chunk.data().size() > kMaxChunkBytes) {
    return InvalidArgument("blob_chunk.data has {} bytes: expected 1 to {}", chunk.data().size(), kMaxChunkBytes);
  }
  if (chunk.offset() == 0) {
    if (chunk.blob().sha256().size() != 32 || chunk.blob().size_bytes() < 1 ||
        chunk.blob().size_bytes() > sensor::kMaxBlobBytes) {
      return InvalidArgument("blob_chunk.blob: expected a SHA-256 of 32 bytes (got {}) and a size of 1 to {} (got {})",
                             chunk.blob().sha256().size(), sensor::kMaxBlobBytes, chunk.blob().size_bytes());
    }
    Begin(chunk.blob().sha256(), chunk.blob().size_bytes());
  }
  const std::int64_t received = blob_.data.size();
  if (chunk.blob().sha256() != blob_.sha256 || chunk.offset() != received ||
      static_cast<std::int64_t>(chunk.data().size()) > size_ - received) {
    return InvalidArgument(
        "blob_chunk at offset {} with {} bytes does not follow: {} of {} bytes of a blob have been received",
        chunk.offset(), chunk.data().size(), received, size_);
  }
  digest_.Add(chunk.data());
  ENFILADE_RETURN_IF_ERROR(blob_.data.Append(chunk.data()));
  if (blob_.data.size() < size_) return false;
  if (digest_.Finish() != blob_.sha256) {
    return DataLoss("the blob of {} bytes does not have the announced SHA-256", size_);
  }
  return true;
}

IngestBlob BlobAssembly::Take() {
  IngestBlob whole = std::move(blob_);
  Begin("", 0);
  return whole;
}

void BlobAssembly::Begin(std::string sha256, std::int64_t size) {
  blob_ = {std::move(sha256), UploadedFile(*space_)};
  digest_ = Sha256Stream();
  size_ = size;
}

}  // namespace enfilade::server
