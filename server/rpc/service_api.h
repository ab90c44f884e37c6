// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "grpcpp/grpcpp.h"
#include "server/app/services.h"
#include "server/rpc/call/grpc_call.h"
#include "server/rpc/call/server_stream.h"
#include "server/rpc/call/unary.h"
#include "server/rpc/call/watch_stream.h"

namespace enfilade::server {

// One service of the API. `Service` is gRPC's generated class, whose functions the lines of the classes below override.
template <typename Service>
class ApiOf : public Service {
 public:
  ApiOf(const Services& services, const CallEnvironment& calls) : services_(services), calls_(calls) {}

 protected:
  CallEntry Enter(const char* rpc, grpc::CallbackServerContext* context) const { return {calls_, rpc, *context}; }

  // A handler of a unary RPC, which returns its response or, if that is large, writes into it.
  template <typename Request, typename Response>
  auto Bind(absl::StatusOr<Response> (*handle)(const Services&, const Call&, const Request&)) const {
    return [this, handle](const Call& call, const Request& request, Response& response) {
      absl::StatusOr<Response> answer = handle(services_, call, request);
      if (!answer.ok()) return answer.status();
      response = *std::move(answer);
      return absl::OkStatus();
    };
  }
  template <typename Request, typename Response>
  auto Bind(absl::Status (*handle)(const Services&, const Call&, const Request&, Response&)) const {
    return [this, handle](const Call& call, const Request& request, Response& response) {
      return handle(services_, call, request, response);
    };
  }
  // A handler that changes the graph of its site.
  template <typename Request, typename Response>
  auto BindChange(grpc::CallbackServerContext* context,
                  absl::StatusOr<Response> (*handle)(const Services&, const Call&, const Request&)) const {
    return [this, context, change = Bind(handle)](const Call& call, const Request& request, Response& response) {
      const absl::Status status = change(call, request, response);
      if (!status.ok() || call.site().empty()) return status;
      const auto version = services_.graph_store.GetVersion(call.context(), SiteId(call.site()));
      if (version.ok()) TellGraphVersion(*context, call.site(), *version);
      return status;
    };
  }
  // A handler that may have the answer at hand.
  template <typename Request, typename Response>
  auto BindNow(std::optional<absl::StatusOr<Response>> (*try_now)(const Services&, const Request&)) const {
    return [this, try_now](const Request& request, Response& response) -> std::optional<absl::Status> {
      std::optional<absl::StatusOr<Response>> answer = try_now(services_, request);
      if (!answer) return std::nullopt;
      if (!answer->ok()) return answer->status();
      response = **std::move(answer);
      return absl::OkStatus();
    };
  }
  template <typename Request, typename Response>
  auto BindNow(std::optional<absl::Status> (*try_now)(const Services&, const Request&, Response&)) const {
    return
        [this, try_now](const Request& request, Response& response) { return try_now(services_, request, response); };
  }
  // A handler that gives what a watch checks.
  template <typename Request, typename Response>
  auto BindWatch(absl::StatusOr<Watch<Response>> (*open)(const Services&, const Call&, const Request&)) const {
    return [this, open](const Call& call, const Request& request) { return open(services_, call, request); };
  }
  // A handler that opens a stream, at once or later.
  template <typename Request, typename Response>
  auto BindStream(absl::StatusOr<MessageSource<Response>> (*open)(const Services&, const Call&, const Request&)) const {
    return [this, open](const Call& call, const Request& request, Opened<Response> opened) {
      opened(open(services_, call, request));
    };
  }
  template <typename Request, typename Response>
  auto BindStream(void (*open)(const Services&, const Call&, const Request&, Opened<Response>)) const {
    return [this, open](const Call& call, const Request& request, Opened<Response> opened) {
      open(services_, call, request, std::move(opened));
    };
  }
  static CallTurn In(CallLane lane = CallLane::kUsual) { return {.lane = lane}; }
  // For RPCs that need the graph of their site: no thread of the executor waits until it has been read.
  CallTurn OnGraph(CallLane lane = CallLane::kUsual) const {
    const auto read = [this](const Call& call, std::function<void(const absl::Status&)> next) {
      if (call.site().empty()) return next(absl::OkStatus());  // the handler says what is wrong
      const absl::StatusOr<std::int64_t> minimum = call.MinGraphVersion();
      if (!minimum.ok()) return next(minimum.status());
      if (*minimum == 0) return services_.graphs.Prepare(SiteId(call.site()), std::move(next));
      services_.graph_waits.Await(SiteId(call.site()), *minimum, call.context().deadline, std::move(next));
    };
    const auto has_minimum = [this](const Call& call) {
      const absl::StatusOr<std::int64_t> minimum = call.MinGraphVersion();
      if (!minimum.ok() || *minimum == 0) return minimum.ok();
      const auto graph = services_.graphs.FindCurrent(SiteId(call.site()));
      return graph != nullptr && graph->graph().version() >= *minimum;
    };
    return {.before = read, .may_answer_now = has_minimum, .lane = lane};
  }

  const Services& services_;
  const CallEnvironment& calls_;
};

}  // namespace enfilade::server
