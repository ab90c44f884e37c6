// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "enfilade/v1/graph_service.pb.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/server_callback.h"
#include "server/app/services.h"

namespace enfilade::server {

// The stream of GraphService.WatchGlobalPoses. Between two looks no thread is held.
grpc::ServerWriteReactor<v1::WatchGlobalPosesResponse>* WatchGlobalPoses(const Services& services,
                                                                         grpc::CallbackServerContext* call,
                                                                         const v1::WatchGlobalPosesRequest* request);

}  // namespace enfilade::server
