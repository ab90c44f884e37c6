// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "server/app/services.h"

namespace enfilade::server {

// LinkPointService.AttachEvidence.
grpc::ServerReadReactor<v1::AttachEvidenceRequest>* AttachEvidence(const Services& services,
                                                                   grpc::CallbackServerContext* call,
                                                                   v1::AttachEvidenceResponse* response);

}  // namespace enfilade::server
