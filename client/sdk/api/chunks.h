// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "enfilade/v1/geometry.pb.h"
#include "enfilade/v1/ingest_service.pb.h"
#include "enfilade/v1/record.pb.h"

namespace enfilade::client {

// The largest chunk that the server takes.
constexpr std::size_t kChunkBytes = 1U << 20;

// A file by its name, without a folder, and its bytes.
struct NamedFile {
  std::string name;
  std::string bytes;
};

// How much of a transfer is done, of `total` bytes. Called from the thread that transfers.
using TransferProgress = std::function<void(std::int64_t done, std::int64_t total)>;

// Calls `send(offset, data)` for `bytes` piece by piece, until it returns false: then the result is false, too.
template <typename Send>
bool ForEachChunk(std::string_view bytes, const Send& send) {
  for (std::size_t offset = 0; offset < bytes.size(); offset += kChunkBytes) {
    if (!send(static_cast<std::int64_t>(offset), bytes.substr(offset, kChunkBytes))) return false;
  }
  return true;
}

// Sends the bytes of a blob as BlobChunks: `write(chunk)` is called for each until it returns false.
template <typename Write>
bool SendBlobChunks(const v1::BlobRef& blob, std::string_view bytes, const Write& write) {
  return ForEachChunk(bytes, [&](std::int64_t offset, std::string_view data) {
    v1::BlobChunk chunk;
    *chunk.mutable_blob() = blob;
    chunk.set_offset(offset);
    chunk.set_data(std::string(data));
    return write(std::move(chunk));
  });
}

}  // namespace enfilade::client
