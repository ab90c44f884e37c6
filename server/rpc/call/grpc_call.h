// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "grpcpp/server_context.h"
#include "server/rpc/call/call.h"

namespace enfilade::server {

// How a call enters the server: what every shape (unary, streams, watch) needs to make its Call.
struct CallEntry {
  const CallEnvironment& environment;
  const char* rpc;  // a string literal
  grpc::CallbackServerContext& context;
};

// The metadata's texts are those of `context`.
IncomingCall ReadIncomingCall(const CallEntry& entry);

// Makes the Call of an RPC, and sends its request id back in the initial metadata "x-request-id". All shapes begin with
// it.
Call BeginCall(const CallEntry& entry);

// Ends the call (Call::Finish), and gives the status to send. An error that will be over soon says in the trailing
// metadata "grpc-retry-pushback-ms" when to try again, as gRPC's own retries expect it.
grpc::Status FinishCall(const Call& call, grpc::CallbackServerContext& context, const absl::Status& status);

// Sends the version of the site's graph that has a call's change, in the trailing metadata "enfilade-graph-version".
void TellGraphVersion(grpc::CallbackServerContext& context, const std::string& site, std::int64_t version);

}  // namespace enfilade::server
