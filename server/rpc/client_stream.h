// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "absl/status/status.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/server_callback.h"
#include "server/app/services.h"
#include "server/rpc/status.h"

namespace enfilade::server {

// The body of every client-streaming RPC. `Handler` is made of (services, context); its Take(request) is called for
// each message, on gRPC's threads, and must not block; its Answer(response) when the client has said all, on the
// executor.
template <typename Handler, typename Request, typename Response>
class ClientStreamReactor final : public grpc::ServerReadReactor<Request> {
 public:
  ClientStreamReactor(const Services& services, grpc::CallbackServerContext* call, const char* name, Response* response)
      : services_(services),
        name_(name),
        response_(response),
        handler_(services,
                 ContextOf(*call, std::chrono::duration<double>(services.options.database.default_deadline_s))) {
    this->StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    if (!ok) return EndOfRequests();
    const absl::Status status = handler_.Take(request_);
    if (status.ok()) return this->StartRead(&request_);
    End(status);
  }

  void OnDone() override {
    services_.metrics.CountCall(name_, status_.code(), std::chrono::steady_clock::now() - begin_);
    delete this;
  }

 private:
  void EndOfRequests() {
    const bool queued = services_.executor.Post([this] { End(handler_.Answer(*response_)); });
    if (!queued) End(absl::ResourceExhaustedError("too many calls are waiting: try again later"));
  }

  void End(const absl::Status& status) {
    status_ = status;
    this->Finish(ToGrpcStatus(status));
  }

  const Services& services_;
  const char* const name_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  Response* const response_;
  Request request_;
  Handler handler_;
  absl::Status status_;
};

}  // namespace enfilade::server
