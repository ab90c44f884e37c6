// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/graph/watch_global_poses.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "grpcpp/alarm.h"
#include "server/rpc/graph/pose_watch.h"
#include "server/rpc/status.h"

namespace enfilade::server {
namespace {

// How soon a stream notices that the server ends.
constexpr auto kMaxWait = std::chrono::milliseconds(500);

// Looks, writes, waits, and again: one of these at any time. Whichever it is, the stream ends behind it.
class WatchReactor final : public grpc::ServerWriteReactor<v1::WatchGlobalPosesResponse> {
 public:
  WatchReactor(const Services& services, absl::StatusOr<PoseWatch> watch) : services_(services) {
    if (watch.ok()) {
      watch_ = *std::move(watch);
      due_ = std::chrono::steady_clock::now();
      QueueLook();
    } else {
      End(watch.status());
    }
  }

  void OnWriteDone(bool ok) override {
    if (!ok) return End(absl::CancelledError("the client has gone"));
    Wait();
  }

  void OnCancel() override {
    MutexLock lock(mutex_);
    gone_ = true;
    alarm_.Cancel();
  }

  void OnDone() override {
    services_.metrics.CountCall("WatchGlobalPoses", status_.code(), std::chrono::steady_clock::now() - begin_);
    delete this;
  }

 private:
  void QueueLook() {
    services_.executor.PostNext([this] { Look(); });
  }

  void Look() {
    due_ = std::chrono::steady_clock::now() + watch_->period();
    const storage::CallContext context =
        storage::CallContext::WithTimeout(std::chrono::duration_cast<std::chrono::nanoseconds>(
            std::chrono::duration<double>(services_.options.database.default_deadline_s)));
    const absl::StatusOr<bool> has_news = watch_->Look(services_, context, message_);
    if (!has_news.ok()) return End(has_news.status());
    if (!*has_news) return Wait();
    StartWrite(&message_);
  }

  void Wait() {
    if (services_.graphs.stopping()) return End(absl::UnavailableError("the server is about to end: call again"));
    const auto now = std::chrono::steady_clock::now();
    const auto wait =
        std::clamp<std::chrono::steady_clock::duration>(due_ - now, std::chrono::milliseconds(1), kMaxWait);
    bool gone = false;
    {
      MutexLock lock(mutex_);
      gone = gone_;
      if (!gone) {
        alarm_.Set(std::chrono::system_clock::now() + wait, [this](bool /*ok*/) { Woken(); });
      }
    }
    if (gone) End(absl::CancelledError("the client has gone"));
  }

  void Woken() {
    {
      // The lock also lets Set return before the alarm may be destroyed.
      MutexLock lock(mutex_);
      if (!gone_ && std::chrono::steady_clock::now() >= due_) {
        QueueLook();
        return;
      }
    }
    Wait();
  }

  void End(const absl::Status& status) {
    status_ = status;
    Finish(ToGrpcStatus(status));
  }

  const Services& services_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::optional<PoseWatch> watch_;
  std::chrono::steady_clock::time_point due_;  // of the next look
  v1::WatchGlobalPosesResponse message_;
  absl::Status status_;

  Mutex mutex_;
  grpc::Alarm alarm_;
  bool gone_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace

grpc::ServerWriteReactor<v1::WatchGlobalPosesResponse>* WatchGlobalPoses(const Services& services,
                                                                         grpc::CallbackServerContext* /*call*/,
                                                                         const v1::WatchGlobalPosesRequest* request) {
  return new WatchReactor(services, PoseWatch::Create(*request));
}

}  // namespace enfilade::server
