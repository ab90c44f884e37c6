// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/uplink/record_stream.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "client/sdk/api/chunks.h"
#include "core/base/error.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"

namespace enfilade::client {
namespace {

// How often the sender checks, while it waits for records, whether the stream has ended.
constexpr auto kIdle = std::chrono::milliseconds(200);

std::string MessageOf(const absl::Status& status) { return std::string(status.message()); }

}  // namespace

bool IsPermanent(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kNotFound:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kPermissionDenied:
    case absl::StatusCode::kUnauthenticated:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kOutOfRange:
    case absl::StatusCode::kUnimplemented:
      return true;
    default:
      return false;
  }
}

RecordStream::RecordStream(const Connection& connection, Spool& spool, SessionId session,
                           const RecordStreamOptions& options, Listener listener)
    : connection_(connection),
      spool_(spool),
      id_(std::move(session)),
      options_(options),
      listener_(std::move(listener)) {}

void RecordStream::Cancel() { Fail(absl::CancelledError("stopped"), End::kBroken); }

RecordStream::Outcome RecordStream::Run() {
  const auto stub = v1::IngestService::NewStub(connection_.channel());
  const auto stream = stub->StreamRecords(&context_);
  std::thread receiver([&] { ReceiveAll(*stream); });
  if (Open(*stream) && SendAll(*stream)) stream->WritesDone();
  receiver.join();
  const absl::Status status = FromGrpcStatus(stream->Finish(), connection_.address());
  const SpoolSession session = Session();
  MutexLock lock(mutex_);
  if (!failure_.status.ok()) return failure_;
  if (session.finished && session.pending() == 0) return {End::kComplete, {}};  // however the stream ended
  if (draining_) return {End::kAgain, {}};
  if (status.ok()) return {End::kBroken, Unavailable("the server at {} ended the stream", connection_.address())};
  return {IsPermanent(status) ? End::kPermanent : End::kBroken, status};
}

bool RecordStream::Open(Stream& stream) {
  v1::StreamRecordsRequest request;
  request.mutable_open()->set_session(convert::NameOf(convert::SessionName{Session().site, id_}));
  if (!stream.Write(request)) return false;
  MutexLock lock(mutex_);
  while (!opened_ && !ended_) changed_.Wait(mutex_);
  return opened_ && !ended_;
}

bool RecordStream::SendAll(Stream& stream) {
  while (true) {
    std::int64_t after_sequence = 0;
    bool room = false;
    {
      MutexLock lock(mutex_);
      if (ended_ || !failure_.status.ok()) return false;
      if (draining_) return true;
      after_sequence = sent_sequence_;
      room = in_flight_.size() < static_cast<std::size_t>(options_.max_batches_in_flight);
    }
    if (!SendPoseReport(stream)) return false;
    const SpoolSession session = Session();
    if (session.finished && session.pending() == 0) return true;
    if (!room || (session.finished && after_sequence >= session.last_sequence)) {
      WaitForRoom();
    } else if (after_sequence >= session.last_sequence) {
      spool_.WaitForRecords(id_, after_sequence, std::chrono::steady_clock::now() + kIdle);
    } else if (!SendNext(stream, after_sequence)) {
      return false;
    }
  }
}

void RecordStream::WaitForRoom() {
  MutexLock lock(mutex_);
  if (!ended_ && !draining_ && failure_.status.ok()) {
    changed_.WaitUntil(mutex_, std::chrono::steady_clock::now() + kIdle);
  }
}

bool RecordStream::SendNext(Stream& stream, std::int64_t after_sequence) {
  const auto records = spool_.ReadBatch(id_, after_sequence, options_.max_batch_records, options_.max_batch_bytes);
  if (!records.ok()) {
    Fail(records.status(), End::kBroken);
    return false;
  }
  if (records->empty()) return true;
  v1::StreamRecordsRequest request;
  for (const sensor::Record& record : *records) {
    if (const sensor::BlobRef* blob = sensor::FindBlob(record); blob && !blobs_sent_.contains(blob->sha256)) {
      const absl::StatusOr<std::string> content = spool_.ReadBlob(*blob);
      if (!content.ok()) {
        Withhold(record.sequence, MessageOf(content.status()));
        return true;
      }
      if (!SendBlob(stream, *blob, *content)) return false;
    }
    *request.mutable_batch()->add_records() = convert::ToProto(record);
  }
  {
    MutexLock lock(mutex_);
    sent_sequence_ = records->back().sequence;
    in_flight_.push_back(sent_sequence_);
  }
  if (!stream.Write(request)) return false;
  listener_.on_sent(records->back().sequence);
  return true;
}

bool RecordStream::SendPoseReport(Stream& stream) {
  std::optional<v1::PoseReport> report = listener_.take_pose_report();
  if (!report) return true;
  v1::StreamRecordsRequest request;
  *request.mutable_pose_report() = *std::move(report);
  return stream.Write(request);
}

bool RecordStream::SendBlob(Stream& stream, const sensor::BlobRef& blob, const std::string& content) {
  v1::BlobRef reference;
  reference.set_sha256(blob.sha256);
  reference.set_size_bytes(blob.size);
  const bool sent = SendBlobChunks(reference, content, [&](v1::BlobChunk chunk) {
    v1::StreamRecordsRequest request;
    *request.mutable_blob_chunk() = std::move(chunk);
    return stream.Write(request);
  });
  if (sent) blobs_sent_.insert(blob.sha256);
  return sent;
}

void RecordStream::ReceiveAll(Stream& stream) {
  v1::StreamRecordsResponse response;
  while (stream.Read(&response)) Receive(response);
  {
    MutexLock lock(mutex_);
    ended_ = true;
    changed_.NotifyAll();
  }
  spool_.NotifyWaiters();
}

void RecordStream::Receive(const v1::StreamRecordsResponse& response) {
  switch (response.response_case()) {
    case v1::StreamRecordsResponse::kOpened:
      return Opened(response.opened().acknowledged_sequence());
    case v1::StreamRecordsResponse::kAcknowledgement:
      return Acknowledged(response.acknowledgement().acknowledged_sequence());
    case v1::StreamRecordsResponse::kRefused:
      return Refused(response.refused());
    case v1::StreamRecordsResponse::kPoseReportRefused:
      return listener_.on_pose_report_refused(response.pose_report_refused().message());
    case v1::StreamRecordsResponse::kMapEntered:
      return listener_.on_map_entered(response.map_entered());
    case v1::StreamRecordsResponse::RESPONSE_NOT_SET:
      break;  // from a newer server
  }
}

void RecordStream::Opened(std::int64_t acknowledged_sequence) {
  const std::int64_t known = Session().acknowledged_sequence;
  if (acknowledged_sequence < known) {
    return Fail(DataLoss("session {}: the server has records up to {}, but it acknowledged up to {} before, and the "
                         "spool has deleted those: was the server's database restored from a backup?",
                         id_.value(), acknowledged_sequence, known),
                End::kPermanent);
  }
  Acknowledged(acknowledged_sequence);
  const std::int64_t stored = Session().acknowledged_sequence;
  MutexLock lock(mutex_);
  opened_ = true;
  sent_sequence_ = stored;
  changed_.NotifyAll();
}

void RecordStream::Acknowledged(std::int64_t sequence) {
  if (absl::Status status = spool_.Acknowledge(id_, sequence); !status.ok())
    return Fail(std::move(status), End::kBroken);
  {
    MutexLock lock(mutex_);
    while (!in_flight_.empty() && in_flight_.front() <= sequence) in_flight_.pop_front();
    changed_.NotifyAll();
  }
  listener_.on_acknowledged(sequence);
}

void RecordStream::Refused(const v1::BatchRefused& refusal) {
  if (refusal.reason() == v1::BatchRefused::REASON_INVALID_RECORD && refusal.sequence() > 0) {
    return Withhold(refusal.sequence(), refusal.message());
  }
  if (refusal.reason() == v1::BatchRefused::REASON_CONFLICTING_RECORD) {
    return Fail(
        AlreadyExists("session {}: record {} on the server differs from the spool's: do two robots record under "
                      "one session id? ({})",
                      id_.value(), refusal.sequence(), refusal.message()),
        End::kPermanent);
  }
  Fail(Internal("session {}: the server refused the batch that starts at record {}: {}", id_.value(),
                refusal.first_sequence(), refusal.message()),
       End::kPermanent);
}

void RecordStream::Withhold(std::int64_t sequence, const std::string& reason) {
  const absl::Status status = spool_.Quarantine(id_, sequence, reason);
  // Its placeholder was refused, too: there is nothing else to send instead.
  if (!status.ok()) {
    return Fail(WithContext(status, fmt::format("record {} was refused ({})", sequence, reason)), End::kPermanent);
  }
  listener_.on_quarantined(sequence, reason);
  {
    MutexLock lock(mutex_);
    draining_ = true;
    changed_.NotifyAll();
  }
  spool_.NotifyWaiters();
}

void RecordStream::Fail(absl::Status status, End end) {
  {
    MutexLock lock(mutex_);
    if (failure_.status.ok()) failure_ = {end, std::move(status)};
    changed_.NotifyAll();
  }
  context_.TryCancel();
  spool_.NotifyWaiters();
}

SpoolSession RecordStream::Session() { return spool_.FindSession(id_).value_or(SpoolSession{}); }

}  // namespace enfilade::client
