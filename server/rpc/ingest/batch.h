// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/sha256.h"
#include "enfilade/v1/ingest_service.pb.h"
#include "server/app/ingest/ingest.h"

namespace enfilade::server {

constexpr int kMaxBatchRecords = 10'000;
constexpr std::size_t kMaxBatchBytes = 4U << 20;
constexpr std::size_t kMaxChunkBytes = 1U << 20;

// The batch as core values, or the reason why the whole batch is refused, with the record at fault.
IngestItem ReadBatch(const v1::RecordBatch& batch);

// Assembles a blob from its chunks. One blob at a time: the chunks of a stream come blob after blob.
class BlobAssembly {
 public:
  // Holds what it has in `space`.
  explicit BlobAssembly(UploadSpace& space) : space_(&space) {}

  // INVALID_ARGUMENT: a chunk out of order, of a different blob, too large, or with an invalid size or digest.
  // DATA_LOSS: the blob's digest is not the announced one. Errors as UploadedFile::Append. True when the blob is
  // complete.
  absl::StatusOr<bool> Add(const v1::BlobChunk& chunk);

  // The complete blob; the next may begin.
  IngestBlob Take();

 private:
  void Begin(std::string sha256, std::int64_t size);

  UploadSpace* space_;
  IngestBlob blob_{"", UploadedFile(*space_)};
  Sha256Stream digest_;
  std::int64_t size_ = 0;
};

}  // namespace enfilade::server
