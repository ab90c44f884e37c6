// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "grpcpp/support/server_callback.h"
#include "server/rpc/call/grpc_call.h"
#include "server/rpc/call/site_of.h"

namespace enfilade::server {

// The body of every unary RPC: handle(call, request, response) runs on the executor, and its answer is sent.
template <typename Request, typename Response, typename Handle>
class UnaryReactor final : public grpc::ServerUnaryReactor {
 public:
  UnaryReactor(const CallEntry& entry, const Request* request, Response* response, Handle handle)
      : context_(entry.context),
        call_(BeginCall(entry)),
        request_(request),
        response_(response),
        handle_(std::move(handle)) {
    call_.set_site(SiteOf(*request_));
  }

  // try_now(request, response), which must not wait, may give the answer without the executor.
  template <typename TryNow>
  void Start(TryNow try_now, const CallTurn& turn) {
    if (const absl::Status status = call_.CheckSite(); !status.ok()) return End(status);
    if (!turn.may_answer_now || turn.may_answer_now(call_)) {
      if (const std::optional<absl::Status> status = try_now(*request_, *response_)) return End(*status);
    }
    lane_ = turn.lane;
    if (!turn.before) return Run();
    turn.before(call_, [this](const absl::Status& ready) { ready.ok() ? Run() : End(ready); });
  }

  void OnCancel() override { call_.Cancel(); }
  void OnDone() override { delete this; }
  // What OnCancel() and OnDone() do is too little to be worth another thread's time: a few percent of a short call.
  bool InternalInlineable() override { return true; }

 private:
  void Run() {
    call_.Run(lane_, [this](const absl::Status& admitted, const storage::CallContext&) {
      End(admitted.ok() ? handle_(call_, *request_, *response_) : admitted);
    });
  }

  void End(const absl::Status& status) { this->Finish(FinishCall(call_, context_, status)); }

  grpc::CallbackServerContext& context_;
  Call call_;
  const Request* const request_;
  Response* const response_;
  const Handle handle_;
  CallLane lane_ = CallLane::kUsual;
};

template <typename Request, typename Response, typename Handle, typename TryNow>
grpc::ServerUnaryReactor* RunUnary(const CallEntry& entry, const Request* request, Response* response, Handle handle,
                                   TryNow try_now, const CallTurn& turn = {}) {
  auto* reactor = new UnaryReactor<Request, Response, Handle>(entry, request, response, std::move(handle));
  reactor->Start(std::move(try_now), turn);
  return reactor;
}

template <typename Request, typename Response, typename Handle>
grpc::ServerUnaryReactor* RunUnary(const CallEntry& entry, const Request* request, Response* response, Handle handle,
                                   const CallTurn& turn = {}) {
  return RunUnary(
      entry, request, response, std::move(handle),
      [](const Request&, Response&) { return std::optional<absl::Status>(); }, turn);
}

}  // namespace enfilade::server
