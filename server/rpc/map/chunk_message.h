// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "absl/status/statusor.h"
#include "grpcpp/support/byte_buffer.h"

namespace enfilade::server {

// Writes the piece's `size` bytes to `data`, from which they are sent.
using ChunkFiller = std::function<absl::Status(char* data)>;

// An ExportMapResponse with a chunk, in the form in which it travels (protobuf's wire format): the bytes go from the
// file into the buffer that gRPC sends, without a message in between that would be copied once more. Errors: those of
// `fill`.
absl::StatusOr<grpc::ByteBuffer> EncodeChunkMessage(std::int32_t file, std::int64_t offset, std::size_t size,
                                                    const ChunkFiller& fill);

}  // namespace enfilade::server
