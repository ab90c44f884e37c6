// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "grpcpp/server_context.h"
#include "grpcpp/support/server_callback.h"
#include "server/app/services.h"
#include "server/rpc/status.h"

namespace enfilade::server {

// Makes the next message of a stream in `message`, which may still hold an earlier one (its buffers are worth keeping);
// false at the end. Called from one thread at a time.
template <typename Response>
using MessageSource = std::function<absl::StatusOr<bool>(Response& message)>;

// Sends what a source makes: while messages are on their way the executor makes the next ones, at most `kAhead`, so
// that a slow client costs that many messages of memory and no thread, and a fast one hardly ever waits for a thread to
// wake.
template <typename Request, typename Response>
class ServerStreamReactor final : public grpc::ServerWriteReactor<Response> {
 public:
  using Open = absl::StatusOr<MessageSource<Response>> (*)(const Services&, const storage::CallContext&,
                                                           const Request&);

  ServerStreamReactor(const Services& services, grpc::CallbackServerContext* call, const char* name,
                      const Request* request, Open open)
      : services_(services), name_(name) {
    const storage::CallContext context =
        ContextOf(*call, std::chrono::duration<double>(services.options.database.default_deadline_s));
    const bool queued = services_.executor.Post([this, context, request, open] {
      absl::StatusOr<MessageSource<Response>> source = open(services_, context, *request);
      if (source.ok()) {
        source_ = *std::move(source);
        Make();
      } else {
        MutexLock lock(mutex_);
        End(source.status());
      }
    });
    if (!queued) {
      MutexLock lock(mutex_);
      End(absl::ResourceExhaustedError("too many calls are waiting: try again later"));
    }
  }

  void OnWriteDone(bool ok) override {
    MutexLock lock(mutex_);
    writing_ = false;
    ++sent_;
    if (!ok) gone_ = true;
    Advance();
  }

  void OnCancel() override {
    MutexLock lock(mutex_);
    gone_ = true;
    Advance();
  }

  void OnDone() override {
    // Finish() may have been called by a thread that still holds the mutex.
    { MutexLock lock(mutex_); }
    services_.metrics.CountCall(name_, status_.code(), std::chrono::steady_clock::now() - begin_);
    delete this;
  }

 private:
  static constexpr std::uint64_t kAhead = 4;

  // Fills the ring. `making_` says that a thread is here: only it touches the source and the message `made_`.
  void Make() {
    while (true) {
      Response* message = nullptr;
      {
        MutexLock lock(mutex_);
        if (gone_ || made_ - sent_ == kAhead) {
          making_ = false;
          Advance();
          return;
        }
        message = &ring_[made_ % kAhead];
      }
      const absl::StatusOr<bool> made = source_(*message);
      MutexLock lock(mutex_);
      if (!made.ok() || !*made) {
        End(made.status());
        return;
      }
      ++made_;
      Advance();
    }
  }

  // No further message: the stream's end, or an error.
  void End(const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    making_ = false;
    ended_ = true;
    status_ = status;
    Advance();
  }

  void Advance() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (writing_ || finished_) return;
    if (gone_) {
      if (making_) return;  // finishing now would free what is being made
      finished_ = true;
      status_ = absl::CancelledError("the client has gone");
      this->Finish(ToGrpcStatus(status_));
    } else if (sent_ < made_) {
      writing_ = true;
      if (!making_ && !ended_) {
        making_ = true;
        services_.executor.PostNext([this] { Make(); });
      }
      this->StartWrite(&ring_[sent_ % kAhead]);
    } else if (ended_) {
      finished_ = true;
      this->Finish(ToGrpcStatus(status_));
    }
  }

  const Services& services_;
  const char* const name_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  MessageSource<Response> source_;
  std::array<Response, kAhead> ring_;

  Mutex mutex_;
  std::uint64_t made_ ABSL_GUARDED_BY(mutex_) = 0;  // messages so far
  std::uint64_t sent_ ABSL_GUARDED_BY(mutex_) = 0;
  bool making_ ABSL_GUARDED_BY(mutex_) = true;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool gone_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status status_;
};

template <typename Request, typename Response>
grpc::ServerWriteReactor<Response>* RunServerStream(
    const Services& services, grpc::CallbackServerContext* call, const char* name, const Request* request,
    absl::StatusOr<MessageSource<Response>> (*open)(const Services&, const storage::CallContext&, const Request&)) {
  return new ServerStreamReactor<Request, Response>(services, call, name, request, open);
}

}  // namespace enfilade::server
