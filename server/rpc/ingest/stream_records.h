// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "enfilade/v1/ingest_service.pb.h"
#include "grpcpp/support/server_callback.h"
#include "server/app/services.h"
#include "server/rpc/call/grpc_call.h"

namespace enfilade::server {

// IngestService.StreamRecords: receives one session's batches and answers with acknowledgements.
grpc::ServerBidiReactor<v1::StreamRecordsRequest, v1::StreamRecordsResponse>* StreamRecords(const Services& services,
                                                                                            const CallEntry& entry);

}  // namespace enfilade::server
