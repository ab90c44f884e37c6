// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "grpcpp/support/byte_buffer.h"
#include "server/rpc/server_stream.h"

namespace enfilade::server {

// MapService.ExportMap, with its messages in the form in which they travel: see EncodeChunkMessage().
absl::StatusOr<MessageSource<grpc::ByteBuffer>> ExportMap(const Services& services, const storage::CallContext& context,
                                                          const grpc::ByteBuffer& encoded_request);

}  // namespace enfilade::server
