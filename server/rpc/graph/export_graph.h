// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/statusor.h"
#include "enfilade/v1/graph_service.pb.h"
#include "server/rpc/server_stream.h"

namespace enfilade::server {

absl::StatusOr<MessageSource<v1::ExportGraphResponse>> ExportGraph(const Services& services,
                                                                   const storage::CallContext& context,
                                                                   const v1::ExportGraphRequest& request);

}  // namespace enfilade::server
