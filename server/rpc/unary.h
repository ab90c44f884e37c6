// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>
#include <utility>

#include "absl/status/statusor.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/server_callback.h"
#include "server/app/services.h"
#include "server/rpc/status.h"

namespace enfilade::server {

// What answers a unary RPC: by a response, or, where that is large, into one.
template <typename Request, typename Response>
using Handle = absl::StatusOr<Response> (*)(const Services&, const storage::CallContext&, const Request&);
template <typename Request, typename Response>
using HandleInto = absl::Status (*)(const Services&, const storage::CallContext&, const Request&, Response&);

template <typename Request, typename Response>
absl::Status Answer(Handle<Request, Response> handle, const Services& services, const storage::CallContext& context,
                    const Request& request, Response& response) {
  absl::StatusOr<Response> answer = handle(services, context, request);
  if (answer.ok()) response = *std::move(answer);
  return answer.status();
}

template <typename Request, typename Response>
absl::Status Answer(HandleInto<Request, Response> handle, const Services& services, const storage::CallContext& context,
                    const Request& request, Response& response) {
  return handle(services, context, request, response);
}

// The body of every unary RPC: `handle` runs on the executor and its answer is sent. `name` is the RPC's, for the
// metrics. `answer_at_once`, which must not wait, may answer without the executor.
template <typename Request, typename Response, typename AnyHandle>
grpc::ServerUnaryReactor* RunUnary(
    const Services& services, grpc::CallbackServerContext* call, const char* name, const Request* request,
    Response* response, AnyHandle handle,
    std::optional<absl::StatusOr<Response>> (*answer_at_once)(const Services&, const Request&) = nullptr) {
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  const storage::CallContext context =
      ContextOf(*call, std::chrono::duration<double>(services.options.database.default_deadline_s));
  const auto begin = std::chrono::steady_clock::now();
  const auto finish = [&services, reactor, name, begin](const absl::Status& status) {
    services.metrics.CountCall(name, status.code(), std::chrono::steady_clock::now() - begin);
    reactor->Finish(ToGrpcStatus(status));
  };
  if (answer_at_once != nullptr) {
    if (std::optional<absl::StatusOr<Response>> answer = answer_at_once(services, *request)) {
      if (answer->ok()) *response = **std::move(answer);
      finish(answer->status());
      return reactor;
    }
  }
  const bool queued = services.executor.Post([&services, context, request, response, handle, finish] {
    if (context.deadline <= std::chrono::steady_clock::now()) {
      return finish(absl::DeadlineExceededError("the deadline passed while the call waited for its turn"));
    }
    finish(Answer<Request, Response>(handle, services, context, *request, *response));
  });
  if (!queued) finish(absl::ResourceExhaustedError("too many calls are waiting: try again later"));
  return reactor;
}

}  // namespace enfilade::server
