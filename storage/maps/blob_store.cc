// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/blob_store.h"

#include "core/base/error.h"
#include "core/base/sha256.h"

namespace enfilade::storage {

absl::Status ValidateBlobs(absl::Span<const BlobView> blobs) {
  for (const BlobView& blob : blobs) {
    if (blob.data.empty() || static_cast<std::int64_t>(blob.data.size()) > sensor::kMaxBlobBytes) {
      return InvalidArgument("a blob has {} bytes: expected 1 to {}", blob.data.size(), sensor::kMaxBlobBytes);
    }
    if (const std::string digest = Sha256(blob.data); digest != blob.sha256) {
      return InvalidArgument("the SHA-256 of a blob is {}, not {} as the caller claims", ToHex(digest),
                             ToHex(blob.sha256));
    }
  }
  return absl::OkStatus();
}

}  // namespace enfilade::storage
