// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/map_service.pb.h"
#include "grpcpp/support/byte_buffer.h"
#include "server/app/services.h"
#include "server/rpc/call/server_stream.h"

namespace enfilade::server {

// MapService.ExportMap, with its messages already encoded: see EncodeChunkMessage().
void ExportMap(const Services& services, const Call& call, const v1::ExportMapRequest& request,
               Opened<grpc::ByteBuffer> opened);

}  // namespace enfilade::server
