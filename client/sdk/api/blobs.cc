// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/blobs.h"

#include <cstdint>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/ingest_service.grpc.pb.h"

namespace enfilade::client {

absl::StatusOr<std::string> DownloadBlob(const Connection& connection, const SiteId& site, const std::string& sha256,
                                         const TransferProgress& progress) {
  v1::DownloadBlobRequest request;
  request.set_parent(NameOf(site));
  request.set_sha256(sha256);
  v1::IngestService::Stub stub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  const auto reader = stub.DownloadBlob(&context, request);
  std::string bytes;
  absl::Status status;
  v1::DownloadBlobResponse part;
  while (status.ok() && reader->Read(&part)) {
    const v1::BlobChunk& chunk = part.chunk();
    if (chunk.offset() != static_cast<std::int64_t>(bytes.size())) {
      status =
          DataLoss("blob {}: the server sent offset {} after {} bytes", ToHex(sha256), chunk.offset(), bytes.size());
      context.TryCancel();
      continue;
    }
    bytes += chunk.data();
    if (progress) progress(static_cast<std::int64_t>(bytes.size()), chunk.blob().size_bytes());
  }
  const absl::Status ended = FromGrpcStatus(reader->Finish(), connection.address());
  ENFILADE_RETURN_IF_ERROR(status);
  ENFILADE_RETURN_IF_ERROR(ended);
  if (Sha256(bytes) == sha256) return bytes;
  return DataLoss("blob {} was damaged in transit (its SHA-256 differs): try again", ToHex(sha256));
}

}  // namespace enfilade::client
