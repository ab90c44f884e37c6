// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "client/sdk/api/chunks.h"
#include "client/sdk/connection.h"
#include "core/base/sha256.h"
#include "enfilade/v1/transfer.pb.h"
#include "grpcpp/support/sync_stream.h"

namespace enfilade::client {

// A file in a manifest.
inline v1::FileEntry EntryOf(const NamedFile& file) {
  v1::FileEntry entry;
  entry.set_name(file.name);
  entry.set_size_bytes(static_cast<std::int64_t>(file.bytes.size()));
  entry.set_sha256(Sha256(file.bytes));
  return entry;
}

// Sends `manifest`, then `files` chunk by chunk, and waits for the answer. `progress` is called after every chunk, if
// set. If the server ends the call early, the error is its reason.
template <typename Request>
absl::Status SendFiles(const Connection& connection, grpc::ClientWriter<Request>& writer, const Request& manifest,
                       absl::Span<const NamedFile> files, const TransferProgress& progress) {
  std::int64_t total = 0;
  for (const NamedFile& file : files) total += static_cast<std::int64_t>(file.bytes.size());
  bool open = writer.Write(manifest);
  std::int64_t sent = 0;
  for (std::size_t i = 0; open && i < files.size(); ++i) {
    open = ForEachChunk(files[i].bytes, [&](std::int64_t offset, std::string_view data) {
      Request message;
      v1::FileChunk& chunk = *message.mutable_chunk();
      chunk.set_file(static_cast<std::int32_t>(i));
      chunk.set_offset(offset);
      chunk.set_data(std::string(data));
      if (!writer.Write(message)) return false;
      sent += static_cast<std::int64_t>(data.size());
      if (progress) progress(sent, total);
      return true;
    });
  }
  writer.WritesDone();  // if the server has ended the call, Finish has the reason
  return FromGrpcStatus(writer.Finish(), connection.address());
}

}  // namespace enfilade::client
