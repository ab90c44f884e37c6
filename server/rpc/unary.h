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

// The body of every unary RPC: `handle(services, context, request)` runs on the executor and its answer is sent.
// `name` is the RPC's, for the metrics. `answer_at_once`, which must not wait, may answer without the executor.
template <typename Request, typename Response>
grpc::ServerUnaryReactor* RunUnary(
    const Services& services, grpc::CallbackServerContext* call, const char* name, const Request* request,
    Response* response, absl::StatusOr<Response> (*handle)(const Services&, const CallContext&, const Request&),
    std::optional<absl::StatusOr<Response>> (*answer_at_once)(const Services&, const Request&) = nullptr) {
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  const CallContext context =
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
    absl::StatusOr<Response> answer = handle(services, context, *request);
    if (answer.ok()) *response = *std::move(answer);
    finish(answer.status());
  });
  if (!queued) finish(absl::ResourceExhaustedError("too many calls are waiting: try again later"));
  return reactor;
}

}  // namespace enfilade::server
