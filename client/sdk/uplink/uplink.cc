// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/uplink/uplink.h"

#include <algorithm>
#include <random>
#include <utility>

#include "client/sdk/uplink/backoff.h"
#include "client/sdk/uplink/session_setup.h"
#include "core/base/error.h"
#include "proto/convert/geometry.h"
#include "proto/convert/record.h"

namespace enfilade::client {
namespace {

using End = RecordStream::End;

RecordStream::Outcome OutcomeOf(const absl::Status& status) {
  if (status.ok()) return {End::kComplete, {}};
  return {IsPermanent(status) ? End::kPermanent : End::kBroken, status};
}

}  // namespace

Uplink::Uplink(const Connection& connection, Spool& spool, SessionId session, const UplinkOptions& options)
    : connection_(connection), spool_(spool), id_(std::move(session)), options_(options) {}

Uplink::~Uplink() { Stop(); }

void Uplink::Start() {
  if (const auto session = spool_.FindSession(id_)) {
    MutexLock lock(mutex_);
    progress_.acknowledged_sequence = session->acknowledged_sequence;
  }
  worker_ = std::thread([this] { Run(); });
}

void Uplink::Stop() {
  {
    MutexLock lock(mutex_);
    stopping_ = true;
    if (stream_) stream_->Cancel();
    changed_.NotifyAll();
  }
  if (worker_.joinable()) worker_.join();
}

std::optional<absl::Status> Uplink::WaitFor(std::chrono::steady_clock::duration timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  MutexLock lock(mutex_);
  while (!result_ && changed_.WaitUntil(mutex_, deadline)) {
  }
  return result_;
}

UplinkProgress Uplink::progress() {
  MutexLock lock(mutex_);
  return progress_;
}

void Uplink::ReportPose(const std::string& map, const PoseWithCovariance& T_map_robot, TimeNs time) {
  v1::PoseReport report;
  report.set_map(map);
  *report.mutable_pose_map_robot() = convert::ToProto(T_map_robot);
  *report.mutable_time() = convert::ToTimestamp(time);
  {
    MutexLock lock(mutex_);
    pose_report_ = std::move(report);
  }
  spool_.NotifyWaiters();
}

void Uplink::Run() {
  Backoff backoff(options_.min_backoff_s, options_.max_backoff_s, std::random_device()());
  absl::Status result;
  while (true) {
    const std::int64_t acknowledged = progress().acknowledged_sequence;
    RecordStream::Outcome outcome = RunOnce();
    {
      MutexLock lock(mutex_);
      progress_.connected = false;
      progress_.last_error = std::string(outcome.status.message());
      result = stopping_ && outcome.end != End::kComplete ? absl::CancelledError("stopped") : std::move(outcome.status);
      if (stopping_ || outcome.end == End::kComplete || outcome.end == End::kPermanent) break;
    }
    if (progress().acknowledged_sequence > acknowledged) backoff.Reset();
    if (outcome.end != End::kAgain && !Sleep(backoff.NextSeconds())) {
      result = absl::CancelledError("stopped");
      break;
    }
  }
  MutexLock lock(mutex_);
  result_ = result;
  changed_.NotifyAll();
}

RecordStream::Outcome Uplink::RunOnce() {
  const std::optional<SpoolSession> session = spool_.FindSession(id_);
  if (!session) return OutcomeOf(NotFound("{}: the spool holds no session {}", spool_.path(), id_.value()));
  if (session->closed) return OutcomeOf(absl::OkStatus());
  if (!session_known_) {
    const auto known = EnsureSession(connection_, *session, options_.create_missing);
    if (!known.ok()) return OutcomeOf(known.status());
    session_known_ = true;
  }
  if (session->finished && session->pending() == 0) return Close();
  RecordStream stream(connection_, spool_, id_, options_.stream, MakeListener());
  {
    MutexLock lock(mutex_);
    if (stopping_) return {End::kBroken, absl::CancelledError("stopped")};
    stream_ = &stream;
    ++progress_.connections;
  }
  RecordStream::Outcome outcome = stream.Run();
  {
    MutexLock lock(mutex_);
    stream_ = nullptr;
  }
  return outcome.end == End::kComplete ? Close() : outcome;
}

RecordStream::Outcome Uplink::Close() {
  const std::optional<SpoolSession> session = spool_.FindSession(id_);
  if (!session) return OutcomeOf(NotFound("{}: the spool holds no session {}", spool_.path(), id_.value()));
  const auto closed = FinishSession(connection_, *session);
  if (!closed.ok()) return OutcomeOf(closed.status());
  return OutcomeOf(spool_.MarkClosed(id_));
}

bool Uplink::Sleep(double seconds) {
  const auto deadline =
      std::chrono::steady_clock::now() +
      std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(seconds));
  MutexLock lock(mutex_);
  while (!stopping_ && changed_.WaitUntil(mutex_, deadline)) {
  }
  return !stopping_;
}

RecordStream::Listener Uplink::MakeListener() {
  RecordStream::Listener listener;
  listener.on_acknowledged = [this](std::int64_t sequence) {
    MutexLock lock(mutex_);
    progress_.connected = true;
    progress_.last_error.clear();
    progress_.acknowledged_sequence = std::max(progress_.acknowledged_sequence, sequence);
  };
  listener.on_sent = [this](std::int64_t sequence) {
    MutexLock lock(mutex_);
    progress_.sent_sequence = sequence;
  };
  listener.on_quarantined = [this](std::int64_t, const std::string&) {
    MutexLock lock(mutex_);
    ++progress_.quarantined;
  };
  listener.on_map_entered = [this](const v1::MapEntered& entered) {
    if (options_.on_map_entered) options_.on_map_entered(entered);
  };
  listener.take_pose_report = [this] {
    MutexLock lock(mutex_);
    return std::exchange(pose_report_, std::nullopt);
  };
  listener.on_pose_report_refused = [this](const std::string& message) {
    MutexLock lock(mutex_);
    ++progress_.poses_refused;
    progress_.pose_error = message;
  };
  return listener;
}

}  // namespace enfilade::client
