#pragma once

#include <chrono>
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

// Sends what a source makes: while one message is on its way the executor makes the next, no more than one ahead, so
// that a slow client costs two messages of memory and no thread.
template <typename Request, typename Response>
class ServerStreamReactor final : public grpc::ServerWriteReactor<Response> {
 public:
  using Open = absl::StatusOr<MessageSource<Response>> (*)(const Services&, const CallContext&, const Request&);

  ServerStreamReactor(const Services& services, grpc::CallbackServerContext* call, const char* name,
                      const Request* request, Open open)
      : services_(services), name_(name) {
    const CallContext context =
        ContextOf(*call, std::chrono::duration<double>(services.options.database.default_deadline_s));
    const bool queued = services_.executor.Post([this, context, request, open] {
      absl::StatusOr<MessageSource<Response>> source = open(services_, context, *request);
      if (source.ok()) {
        source_ = *std::move(source);
        Make();
      } else {
        Made(source.status());
      }
    });
    if (!queued) Made(absl::ResourceExhaustedError("too many calls are waiting: try again later"));
  }

  void OnWriteDone(bool ok) override {
    MutexLock lock(mutex_);
    writing_ = false;
    if (!ok) gone_ = true;
    Advance();
  }

  void OnCancel() override {
    MutexLock lock(mutex_);
    gone_ = true;
    Advance();
  }

  void OnDone() override {
    services_.metrics.CountCall(name_, status_.code(), std::chrono::steady_clock::now() - begin_);
    delete this;
  }

 private:
  void Make() { Made(source_(messages_[next_])); }

  // A message is made; or there is none: the end (false), or an error.
  void Made(const absl::StatusOr<bool>& made) {
    MutexLock lock(mutex_);
    making_ = false;
    made_ = made.ok() && *made;
    ended_ = !made_;
    status_ = made.status();
    Advance();
  }

  void Advance() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (writing_ || finished_) return;
    if (gone_) {
      if (making_) return;  // finishing now would free what is being made
      finished_ = true;
      status_ = absl::CancelledError("the client has gone");
      this->Finish(ToGrpcStatus(status_));
    } else if (made_) {
      writing_ = true;
      made_ = false;
      making_ = true;
      Response* message = &messages_[next_];
      next_ = 1 - next_;
      services_.executor.PostNext([this] { Make(); });
      this->StartWrite(message);
    } else if (ended_) {
      finished_ = true;
      this->Finish(ToGrpcStatus(status_));
    }
  }

  const Services& services_;
  const char* const name_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  MessageSource<Response> source_;
  Response messages_[2];
  int next_ = 0;  // the one that is being made; the other is being written

  Mutex mutex_;
  bool making_ ABSL_GUARDED_BY(mutex_) = true;
  bool made_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool gone_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status status_;
};

// The body of every server-streaming RPC: `open` finds what is asked for and gives the source of the messages.
template <typename Request, typename Response>
grpc::ServerWriteReactor<Response>* RunServerStream(
    const Services& services, grpc::CallbackServerContext* call, const char* name, const Request* request,
    absl::StatusOr<MessageSource<Response>> (*open)(const Services&, const CallContext&, const Request&)) {
  return new ServerStreamReactor<Request, Response>(services, call, name, request, open);
}

}  // namespace enfilade::server
