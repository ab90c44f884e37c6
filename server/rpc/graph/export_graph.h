// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/graph_service.pb.h"
#include "server/app/services.h"
#include "server/rpc/call/server_stream.h"

namespace enfilade::server {

absl::StatusOr<MessageSource<v1::ExportGraphResponse>> ExportGraph(const Services& services, const Call& call,
                                                                   const v1::ExportGraphRequest& request);

}  // namespace enfilade::server
