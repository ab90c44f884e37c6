// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/status.h"
#include "grpcpp/support/status.h"

namespace enfilade::server {

// The message, cut after about 2000 bytes: it may quote what the client sent. A longer one would not reach the client,
// and the responses of its other calls would not, either.
std::string BoundedMessage(const absl::Status& status);

// The same code and BoundedMessage, but INTERNAL instead of UNKNOWN: an error without a class is a fault of the server.
grpc::Status ToGrpcStatus(const absl::Status& status);

}  // namespace enfilade::server
