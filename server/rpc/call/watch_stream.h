// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "grpcpp/alarm.h"
#include "grpcpp/support/server_callback.h"
#include "server/rpc/call/grpc_call.h"
#include "server/rpc/call/site_of.h"

namespace enfilade::server {

// An open-ended stream of changes.
template <typename Response>
struct Watch {
  std::chrono::steady_clock::duration period{};  // from one check for changes to the next; positive
  // Once, before the first check, on the executor in the call's turn. It may wait. Null: nothing.
  std::function<absl::Status(const storage::CallContext&)> open = nullptr;
  // Before each check: calls `then` once, from any thread, with whether there may be something to send, or with the
  // error that ends the stream. Must not wait. Null: every check is made.
  std::function<void(std::function<void(const absl::StatusOr<bool>&)> then)> look = nullptr;
  // Writes what changed since the last check into the message, which may hold an earlier one. False: nothing to send.
  // One check at a time, on the threads of watches. While a client does not read, nothing is checked.
  std::function<absl::StatusOr<bool>(const storage::CallContext&, Response&)> check;
  // Whether the last message has a continuation: then the next check follows at once, without a look. Null: none has.
  std::function<bool()> has_more = nullptr;
  std::function<bool()> stopping;  // the server shuts down: the stream ends with UNAVAILABLE
};

// Looks, checks, writes, waits for the rest of the period, and so on: one of these at any time, which ends the stream
// if it has to end.
template <typename Response>
class WatchReactor final : public grpc::ServerWriteReactor<Response> {
 public:
  template <typename Request, typename Open>
  WatchReactor(const CallEntry& entry, const Request& request, const Open& open)
      : context_(entry.context), call_(BeginCall(entry)) {
    call_.set_site(SiteOf(request));
    absl::StatusOr<Watch<Response>> watch = open(call_, request);
    if (watch.ok()) {
      watch_ = *std::move(watch);
      Begin();
    } else {
      End(watch.status());
    }
  }

  void OnWriteDone(bool ok) override {
    if (!ok) return End(ClientHasGone());
    if (watch_.has_more && watch_.has_more() && !watch_.stopping()) return QueueCheck();
    Wait();
  }

  void OnCancel() override {
    call_.Cancel();
    MutexLock lock(mutex_);
    gone_ = true;
    alarm_.Cancel();
  }

  void OnDone() override { delete this; }

 private:
  // How soon a stream notices that the server shuts down.
  static constexpr auto kMaxWait = std::chrono::milliseconds(500);

  static absl::Status ClientHasGone() { return absl::CancelledError("the client has gone"); }

  void Begin() {
    if (!watch_.open) return Look();
    call_.RunStep(CallLane::kUsual, [this](const absl::Status& admitted, const storage::CallContext& context) {
      const absl::Status status = admitted.ok() ? watch_.open(context) : admitted;
      status.ok() ? Look() : End(status);
    });
  }

  void Look() {
    if (const absl::Status status = call_.CheckSite(); !status.ok()) return End(status);
    due_ = std::chrono::steady_clock::now() + watch_.period;
    if (!watch_.look) return QueueCheck();
    watch_.look([this](const absl::StatusOr<bool>& news) {
      if (!news.ok()) return End(news.status());
      *news ? QueueCheck() : Wait();
    });
  }

  void QueueCheck() {
    call_.ContinueWatch([this] { Check(); });
  }

  void Check() {
    const absl::StatusOr<bool> changed = watch_.check(call_.StepContext(), message_);
    if (!changed.ok()) return End(changed.status());
    if (!*changed) return Wait();
    this->StartWrite(&message_);
  }

  void Wait() {
    if (watch_.stopping()) return End(absl::UnavailableError("the server is shutting down: call again"));
    const auto now = std::chrono::steady_clock::now();
    const auto wait =
        std::clamp<std::chrono::steady_clock::duration>(due_ - now, std::chrono::milliseconds(1), kMaxWait);
    bool gone = false;
    {
      MutexLock lock(mutex_);
      gone = gone_;
      if (!gone) {
        alarm_.Set(std::chrono::system_clock::now() + wait, [this](bool /*ok*/) { OnAlarm(); });
      }
    }
    if (gone) End(ClientHasGone());
  }

  void OnAlarm() {
    bool due = false;
    {
      // The lock also lets Set return before the alarm may be destroyed.
      MutexLock lock(mutex_);
      due = !gone_ && std::chrono::steady_clock::now() >= due_;
    }
    if (!due) return Wait();
    Look();
  }

  void End(const absl::Status& status) { this->Finish(FinishCall(call_, context_, status)); }

  grpc::CallbackServerContext& context_;
  Call call_;
  Watch<Response> watch_;
  std::chrono::steady_clock::time_point due_;  // of the next check
  Response message_;

  Mutex mutex_;
  grpc::Alarm alarm_;
  bool gone_ ABSL_GUARDED_BY(mutex_) = false;
};

// open(call, request), which must not wait, gives the Watch or the reason why there is none.
template <typename Response, typename Request, typename Open>
grpc::ServerWriteReactor<Response>* RunWatch(const CallEntry& entry, const Request* request, const Open& open) {
  return new WatchReactor<Response>(entry, *request, open);
}

}  // namespace enfilade::server
