// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "absl/status/status.h"
#include "grpcpp/support/server_callback.h"
#include "server/rpc/call/grpc_call.h"
#include "server/rpc/call/site_of.h"
#include "server/rpc/call/status.h"

namespace enfilade::server {

// The body of every client-streaming RPC. `make_handler(call)` makes its handler, whose Take(request) is called for
// each message, on gRPC's threads, and must not block. After the client's last message Answer(response) runs on the
// executor.
template <typename Handler, typename Request, typename Response>
class ClientStreamReactor final : public grpc::ServerReadReactor<Request> {
 public:
  template <typename MakeHandler>
  ClientStreamReactor(const CallEntry& entry, Response* response, const MakeHandler& make_handler)
      : call_(BeginCall(entry)), response_(response), handler_(make_handler(call_)) {
    this->StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    if (!ok) return EndOfRequests();
    if (call_.site().empty()) call_.set_site(SiteOf(request_));
    const absl::Status status = handler_.Take(request_);
    if (status.ok()) return this->StartRead(&request_);
    End(status);
  }

  void OnCancel() override { call_.Cancel(); }
  void OnDone() override { delete this; }

 private:
  void EndOfRequests() {
    call_.Run([this](const absl::Status& admitted, const storage::CallContext&) {
      End(admitted.ok() ? handler_.Answer(*response_) : admitted);
    });
  }

  void End(const absl::Status& status) {
    call_.Finish(status);
    this->Finish(ToGrpcStatus(status));
  }

  Call call_;
  Response* const response_;
  Request request_;
  Handler handler_;
};

template <typename Handler, typename Request, typename Response, typename MakeHandler>
grpc::ServerReadReactor<Request>* RunClientStream(const CallEntry& entry, Response* response,
                                                  const MakeHandler& make_handler) {
  return new ClientStreamReactor<Handler, Request, Response>(entry, response, make_handler);
}

}  // namespace enfilade::server
