// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/sdk/api/chunks.h"
#include "client/sdk/connection.h"
#include "core/base/sha256.h"
#include "enfilade/v1/transfer.pb.h"
#include "google/protobuf/repeated_ptr_field.h"
#include "grpcpp/support/sync_stream.h"

namespace enfilade::client {

// Checks the chunks of a download against its manifest. All errors are DATA_LOSS.
class DownloadCheck {
 public:
  explicit DownloadCheck(const google::protobuf::RepeatedPtrField<v1::FileEntry>& files);

  // An error if the chunk belongs to no file of the manifest, or does not follow what the file has so far.
  absl::Status Add(const v1::FileChunk& chunk);
  // Call once, at the end of the stream. An error names the first file that is incomplete or has another SHA-256.
  absl::Status Finish();

  // Of all files, by the manifest.
  std::int64_t total() const { return total_; }
  std::int64_t received() const { return received_; }

 private:
  struct File {
    v1::FileEntry entry;
    std::int64_t size = 0;  // received
    Sha256Stream hash;
  };

  std::vector<File> files_;
  std::int64_t total_ = 0;
  std::int64_t received_ = 0;
};

// Where ReceiveFiles puts what it receives: `start(manifest)` is called for the first message, `take(chunk)` for every
// chunk once it is checked; both return an absl::Status, and the first error cancels the call. `progress(done, total)`
// is called after every chunk, if set.
template <typename Start, typename Take>
struct FileSink {
  Start start;
  Take take;
  TransferProgress progress;
};

// Reads a stream of one manifest and the chunks of its files to its end. DATA_LOSS: as DownloadCheck, or no manifest
// comes first.
template <typename Response, typename Sink>
absl::Status ReceiveFiles(const Connection& connection, grpc::ClientContext& context,
                          std::unique_ptr<grpc::ClientReader<Response>> reader, const Sink& sink) {
  Response part;
  if (!reader->Read(&part)) {
    const absl::Status status = FromGrpcStatus(reader->Finish(), connection.address());
    return status.ok() ? absl::DataLossError("the server sent no manifest") : status;
  }
  absl::Status status = part.has_manifest() ? sink.start(part.manifest())
                                            : absl::DataLossError("the server's first message is not a manifest");
  DownloadCheck check(part.manifest().files());
  while (status.ok() && reader->Read(&part)) {
    status = check.Add(part.chunk());
    if (status.ok()) status = sink.take(part.chunk());
    if (status.ok() && sink.progress) sink.progress(check.received(), check.total());
  }
  if (!status.ok()) context.TryCancel();
  const absl::Status ended = FromGrpcStatus(reader->Finish(), connection.address());
  if (!status.ok()) return status;
  return ended.ok() ? check.Finish() : ended;
}

}  // namespace enfilade::client
