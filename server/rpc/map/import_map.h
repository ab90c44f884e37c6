// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "enfilade/v1/map_service.pb.h"
#include "grpcpp/support/server_callback.h"
#include "server/app/services.h"
#include "server/rpc/call/grpc_call.h"

namespace enfilade::server {

// MapService.ImportMap: collects the files, then makes them the map's newest revision.
grpc::ServerReadReactor<v1::ImportMapRequest>* ImportMap(const Services& services, const CallEntry& entry,
                                                         v1::ImportMapResponse* response);

}  // namespace enfilade::server
