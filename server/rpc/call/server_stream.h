// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/error.h"
#include "core/base/mutex.h"
#include "grpcpp/impl/codegen/proto_utils.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/server_callback.h"
#include "server/rpc/call/grpc_call.h"
#include "server/rpc/call/site_of.h"

namespace enfilade::server {

// Makes the next message of a stream in `message`, which may hold an earlier one (its buffers are worth keeping); false
// at the end. Called from one thread at a time.
template <typename Response>
using MessageSource = std::function<absl::StatusOr<bool>(Response& message)>;

// Takes the source of a stream, or the reason why there is none, from the thread that opens the stream or, later, from
// another one of the executor.
template <typename Response>
using Opened = std::function<void(absl::StatusOr<MessageSource<Response>> source)>;

// The body of every server-streaming RPC. Sends what a source makes: while messages are on their way the executor makes
// the next ones, at most `kAhead`. So a slow client costs that many messages of memory and no thread, and a fast one
// hardly ever waits for a thread to wake.
template <typename Response>
class ServerStreamReactor final : public grpc::ServerWriteReactor<Response> {
 public:
  // open(call, opened) runs on the executor.
  ServerStreamReactor(const CallEntry& entry, std::string site, std::function<void(const Call&, Opened<Response>)> open,
                      const CallTurn& turn)
      : context_(entry.context), call_(BeginCall(entry)), open_(std::move(open)), lane_(turn.lane) {
    call_.set_site(std::move(site));
    if (turn.before) {
      turn.before(call_, [this](const absl::Status& ready) { ready.ok() ? Open() : OnOpened(ready); });
    } else {
      Open();
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
    call_.Cancel();
    MutexLock lock(mutex_);
    gone_ = true;
    Advance();
  }

  void OnDone() override {
    // Finish() may have been called by a thread that still holds the mutex.
    { MutexLock lock(mutex_); }
    delete this;
  }

 private:
  static constexpr std::uint64_t kAhead = 4;

  void Open() {
    call_.Run(lane_, [this](const absl::Status& admitted, const storage::CallContext&) {
      if (!admitted.ok()) return OnOpened(admitted);
      open_(call_, [this](absl::StatusOr<MessageSource<Response>> source) { OnOpened(std::move(source)); });
    });
  }

  void OnOpened(absl::StatusOr<MessageSource<Response>> source) {
    if (source.ok()) {
      source_ = *std::move(source);
      return Make();
    }
    MutexLock lock(mutex_);
    End(source.status());
  }

  // Fills the ring. `making_` says that a thread is here: only it touches the source and the message `made_`. A client
  // that reads as fast as messages are made gets them in turns, between which other calls have theirs.
  void Make() {
    for (std::uint64_t i = 0; i < kAhead; ++i) {
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
    call_.ContinueBulk([this] { Make(); });
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
      status_ = absl::CancelledError("the client has gone");
      EndCall();
    } else if (sent_ < made_) {
      writing_ = true;
      if (!making_ && !ended_) {
        making_ = true;
        call_.ContinueBulk([this] { Make(); });
      }
      this->StartWrite(&ring_[sent_ % kAhead]);
    } else if (ended_) {
      EndCall();
    }
  }

  void EndCall() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    finished_ = true;
    this->Finish(FinishCall(call_, context_, status_));
  }

  grpc::CallbackServerContext& context_;
  Call call_;
  const std::function<void(const Call&, Opened<Response>)> open_;
  const CallLane lane_;
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
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
};

// open(call, request, opened) opens the stream, at once or later: see Opened.
template <typename Response, typename Request, typename Open>
grpc::ServerWriteReactor<Response>* RunServerStream(const CallEntry& entry, const Request* request, Open open,
                                                    const CallTurn& turn = {}) {
  const auto open_with_request = [request, open](const Call& call, Opened<Response> opened) {
    open(call, *request, std::move(opened));
  };
  return new ServerStreamReactor<Response>(entry, SiteOf(*request), open_with_request, turn);
}

// The same for an RPC that makes its messages in the form in which they travel.
template <typename Request, typename Open>
grpc::ServerWriteReactor<grpc::ByteBuffer>* RunRawServerStream(const CallEntry& entry,
                                                               const grpc::ByteBuffer* encoded_request, Open open) {
  grpc::ByteBuffer bytes = *encoded_request;
  const auto request = std::make_shared<Request>();
  const grpc::Status decoded = grpc::SerializationTraits<Request>::Deserialize(&bytes, request.get());
  std::string site = decoded.ok() ? SiteOf(*request) : "";
  const auto open_decoded = [request, decoded, open](const Call& call, Opened<grpc::ByteBuffer> opened) {
    if (decoded.ok()) return open(call, *request, std::move(opened));
    opened(InvalidArgument("the request cannot be decoded: {}", decoded.error_message()));
  };
  return new ServerStreamReactor<grpc::ByteBuffer>(entry, std::move(site), open_decoded, CallTurn{});
}

}  // namespace enfilade::server
