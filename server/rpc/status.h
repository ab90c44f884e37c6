// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "absl/status/status.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/status.h"
#include "storage/call_context.h"

namespace enfilade::server {

// The same code and message. UNKNOWN never leaves the server: an error that nobody has classified is INTERNAL.
grpc::Status ToGrpcStatus(const absl::Status& status);

// The call's deadline, or `otherwise` from now where the client set none; and who calls, by the request metadata
// `enfilade-actor`, for the audit trail.
storage::CallContext ContextOf(const grpc::CallbackServerContext& call, std::chrono::duration<double> otherwise);

}  // namespace enfilade::server
