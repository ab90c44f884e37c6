// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "enfilade/v1/link_point_service.pb.h"
#include "grpcpp/support/server_callback.h"
#include "server/app/services.h"
#include "server/rpc/call/grpc_call.h"

namespace enfilade::server {

// LinkPointService.AttachEvidence.
grpc::ServerReadReactor<v1::AttachEvidenceRequest>* AttachEvidence(const Services& services, const CallEntry& entry,
                                                                   v1::AttachEvidenceResponse* response);

}  // namespace enfilade::server
