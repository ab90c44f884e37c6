// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/ingest/download_blob.h"

#include <memory>
#include <string>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/ingest/batch.h"

namespace enfilade::server {

absl::StatusOr<MessageSource<v1::DownloadBlobResponse>> DownloadBlob(const Services& services, const Call& call,
                                                                     const v1::DownloadBlobRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  if (request.sha256().size() != 32) {
    return InvalidArgument("sha256 has {} bytes: expected 32", request.sha256().size());
  }
  ENFILADE_ASSIGN_OR_RETURN(std::string data, services.blobs.Get(call.context(), site, request.sha256()));
  auto bytes = std::make_shared<const std::string>(std::move(data));
  return [bytes, sha256 = request.sha256(),
          offset = std::size_t{0}](v1::DownloadBlobResponse& message) mutable -> absl::StatusOr<bool> {
    if (offset == bytes->size()) return false;
    v1::BlobChunk& chunk = *message.mutable_chunk();
    chunk.mutable_blob()->set_sha256(sha256);
    chunk.mutable_blob()->set_size_bytes(static_cast<std::int64_t>(bytes->size()));
    chunk.set_offset(static_cast<std::int64_t>(offset));
    chunk.set_data(bytes->substr(offset, kMaxChunkBytes));
    offset += chunk.data().size();
    return true;
  };
}

}  // namespace enfilade::server
