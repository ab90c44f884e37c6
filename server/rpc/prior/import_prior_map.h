// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "enfilade/v1/prior_map_service.pb.h"
#include "grpcpp/support/server_callback.h"
#include "server/app/services.h"
#include "server/rpc/call/grpc_call.h"

namespace enfilade::server {

// PriorMapService.ImportPriorMap: collects the file, then finds the walls in it.
grpc::ServerReadReactor<v1::ImportPriorMapRequest>* ImportPriorMap(const Services& services, const CallEntry& entry,
                                                                   v1::ImportPriorMapResponse* response);

}  // namespace enfilade::server
