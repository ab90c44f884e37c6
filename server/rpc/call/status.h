// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "grpcpp/support/status.h"

namespace enfilade::server {

// The same code and message, but INTERNAL instead of UNKNOWN: an error without a class is a fault of the server.
grpc::Status ToGrpcStatus(const absl::Status& status);

}  // namespace enfilade::server
