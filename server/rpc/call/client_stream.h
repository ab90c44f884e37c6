// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "core/base/mutex.h"
#include "fmt/format.h"
#include "grpcpp/alarm.h"
#include "grpcpp/support/server_callback.h"
#include "server/rpc/call/grpc_call.h"
#include "server/rpc/call/site_of.h"

namespace enfilade::server {

// The body of every client-streaming RPC. `make_handler()` makes its handler, whose Take(request) is called for
// each message, on gRPC's threads, and must not block. After the client's last message Answer(context, response) runs
// in the lane of slow calls, with a deadline that starts then: the uploads that are taken into memory are few.
//
// An upload may take as long as it makes progress, unless the client has set a deadline: it ends with DEADLINE_EXCEEDED
// when no message has come for the default timeout.
template <typename Handler, typename Request, typename Response>
class ClientStreamReactor final : public grpc::ServerReadReactor<Request> {
 public:
  template <typename MakeHandler>
  ClientStreamReactor(const CallEntry& entry, Response* response, const MakeHandler& make_handler)
      : context_(entry.context),
        call_(BeginCall(entry)),
        response_(response),
        handler_(make_handler()),
        patience_(entry.environment.default_timeout) {
    SetAlarm(patience_);
    this->StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    {
      MutexLock lock(mutex_);
      if (!reading_) return;  // the alarm has ended the call
      last_progress_ = Clock::now();
      reading_ = ok;
    }
    if (!ok) {
      alarm_.Cancel();
      return EndOfRequests();
    }
    if (call_.site().empty()) call_.set_site(SiteOf(request_));
    const absl::Status status = handler_.Take(request_);
    if (status.ok()) return this->StartRead(&request_);
    if (!StopReading()) return;
    alarm_.Cancel();
    End(status);
  }

  void OnCancel() override { call_.Cancel(); }
  void OnDone() override {
    (void)StopReading();
    alarm_.Cancel();
    Release();
  }

 private:
  using Clock = std::chrono::steady_clock;

  // Whether the caller is the one who ends the reading.
  bool StopReading() {
    MutexLock lock(mutex_);
    return std::exchange(reading_, false);
  }

  void SetAlarm(Clock::duration wait) {
    alarm_.Set(std::chrono::system_clock::now() + std::chrono::duration_cast<std::chrono::system_clock::duration>(wait),
               [this](bool /*ok*/) { OnAlarm(); });
  }

  void OnAlarm() {
    bool stalled = false;
    {
      MutexLock lock(mutex_);
      const Clock::duration idle = Clock::now() - last_progress_;
      if (reading_ && idle < patience_) return SetAlarm(patience_ - idle);
      stalled = std::exchange(reading_, false);
    }
    if (stalled) {
      End(absl::DeadlineExceededError(
          fmt::format("nothing came for {:g} s", std::chrono::duration<double>(patience_).count())));
    }
    Release();
  }

  void EndOfRequests() {
    call_.RunStep(CallLane::kSlow, [this](const absl::Status& admitted, const storage::CallContext& context) {
      End(admitted.ok() ? handler_.Answer(context, *response_) : admitted);
    });
  }

  void End(const absl::Status& status) { this->Finish(FinishCall(call_, context_, status)); }

  void Release() {
    if (users_.fetch_sub(1) == 1) delete this;
  }

  grpc::CallbackServerContext& context_;
  Call call_;
  Response* const response_;
  Request request_;
  Handler handler_;
  const Clock::duration patience_;
  std::atomic<int> users_ = 2;  // gRPC and the alarm

  Mutex mutex_;
  bool reading_ ABSL_GUARDED_BY(mutex_) = true;
  Clock::time_point last_progress_ ABSL_GUARDED_BY(mutex_) = Clock::now();
  grpc::Alarm alarm_;
};

template <typename Handler, typename Request, typename Response, typename MakeHandler>
grpc::ServerReadReactor<Request>* RunClientStream(const CallEntry& entry, Response* response,
                                                  const MakeHandler& make_handler) {
  return new ClientStreamReactor<Handler, Request, Response>(entry, response, make_handler);
}

}  // namespace enfilade::server
