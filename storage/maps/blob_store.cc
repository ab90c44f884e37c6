// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/blob_store.h"

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"

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

absl::StatusOr<std::map<std::string, std::string>> BlobStore::GetAll(const CallContext& context, const SiteId& site,
                                                                     const std::vector<std::string>& sha256) const {
  std::map<std::string, std::string> blobs;
  for (const std::string& digest : sha256) {
    ENFILADE_ASSIGN_OR_RETURN(blobs[digest], Get(context, site, digest));
  }
  return blobs;
}

}  // namespace enfilade::storage
