// SPDX-License-Identifier: Apache-2.0
#include "tests/support/fake_server/fake_ingest_service.h"

#include <chrono>
#include <utility>

#include "core/base/sha256.h"

namespace enfilade::testing {

grpc::Status FakeServer::Ingest::StreamRecords(grpc::ServerContext* context, Stream* stream) {
  v1::StreamRecordsRequest request;
  if (!stream->Read(&request) || !request.has_open()) {
    return {grpc::StatusCode::INVALID_ARGUMENT, "the first message must be open"};
  }
  if (auto status = owner_.At(Moment::kOpenReceived); !status.ok()) return status;
  const std::string name = request.open().session();
  v1::StreamRecordsResponse response;
  {
    MutexLock lock(owner_.mutex_);
    ++owner_.streams_opened_;
    const auto session = owner_.sessions_.find(name);
    if (session == owner_.sessions_.end()) return {grpc::StatusCode::NOT_FOUND, name + " does not exist"};
    response.mutable_opened()->set_acknowledged_sequence(AcknowledgedOf(session->second));
  }
  stream->Write(response);
  if (auto status = owner_.At(Moment::kOpenedSent); !status.ok()) return status;
  if (owner_.behaviour_.map_entered) {
    *response.mutable_map_entered() = *owner_.behaviour_.map_entered;
    stream->Write(response);
  }
  std::string blob;
  while (stream->Read(&request)) {
    if (request.has_pose_report()) {
      TakePose(*stream, request.pose_report());
      continue;
    }
    const auto status = request.has_batch() ? TakeBatch(context, *stream, name, request.batch())
                                            : TakeChunk(request.blob_chunk(), blob);
    if (!status.ok()) return status;
  }
  return owner_.At(Moment::kHalfClosed);
}

grpc::Status FakeServer::Ingest::TakeChunk(const v1::BlobChunk& chunk, std::string& blob) {
  if (auto status = owner_.At(Moment::kChunkReceived); !status.ok()) return status;
  if (chunk.offset() == 0) blob.clear();
  if (chunk.offset() != static_cast<std::int64_t>(blob.size()) || chunk.data().size() > (1U << 20)) {
    return {grpc::StatusCode::INVALID_ARGUMENT, "the chunk is out of order or too large"};
  }
  blob += chunk.data();
  if (static_cast<std::int64_t>(blob.size()) < chunk.blob().size_bytes()) return grpc::Status::OK;
  if (Sha256(blob) != chunk.blob().sha256()) return {grpc::StatusCode::DATA_LOSS, "the hash does not match"};
  MutexLock lock(owner_.mutex_);
  owner_.blobs_[chunk.blob().sha256()] = blob;
  return grpc::Status::OK;
}

void FakeServer::Ingest::TakePose(Stream& stream, const v1::PoseReport& report) {
  std::optional<std::string> reason;
  if (owner_.behaviour_.refuse_pose) reason = owner_.behaviour_.refuse_pose(report);
  if (reason) {
    v1::StreamRecordsResponse response;
    response.mutable_pose_report_refused()->set_message(*reason);
    stream.Write(response);
    return;
  }
  MutexLock lock(owner_.mutex_);
  owner_.pose_reports_.push_back(report);
}

grpc::Status FakeServer::Ingest::TakeBatch(grpc::ServerContext* context, Stream& stream, const std::string& name,
                                           const v1::RecordBatch& batch) {
  if (auto status = owner_.At(Moment::kBatchReceived); !status.ok()) return status;
  v1::StreamRecordsResponse response = Store(name, batch);
  if (response.has_refused()) {
    stream.Write(response);
    return grpc::Status::OK;
  }
  if (auto status = owner_.At(Moment::kBatchStored); !status.ok()) return status;
  {
    MutexLock lock(owner_.mutex_);
    while (owner_.hold_acknowledgements_ && !owner_.stopping_ && !context->IsCancelled()) {
      owner_.changed_.WaitUntil(owner_.mutex_, std::chrono::steady_clock::now() + std::chrono::milliseconds(20));
    }
  }
  stream.Write(response);
  return owner_.At(Moment::kAcknowledged);
}

v1::StreamRecordsResponse FakeServer::Ingest::Store(const std::string& name, const v1::RecordBatch& batch) {
  v1::StreamRecordsResponse response;
  MutexLock lock(owner_.mutex_);
  Session& session = owner_.sessions_[name];
  owner_.records_received_ += batch.records_size();
  for (const v1::Record& record : batch.records()) {
    std::optional<std::string> reason;
    if (owner_.behaviour_.refuse) reason = owner_.behaviour_.refuse(record);
    if (record.has_image() && !owner_.blobs_.contains(record.image().content().sha256())) reason = "blob missing";
    if (!reason) continue;
    v1::BatchRefused& refused = *response.mutable_refused();
    refused.set_first_sequence(batch.records(0).sequence());
    refused.set_sequence(record.sequence());
    refused.set_reason(v1::BatchRefused::REASON_INVALID_RECORD);
    refused.set_message(*reason);
    return response;
  }
  for (const v1::Record& record : batch.records()) {
    const auto [stored, fresh] = session.records.emplace(record.sequence(), record);
    if (fresh) continue;
    ++(stored->second.SerializeAsString() == record.SerializeAsString() ? session.duplicates : session.conflicts);
  }
  if (session.conflicts > 0) {
    response.mutable_refused()->set_first_sequence(batch.records(0).sequence());
    response.mutable_refused()->set_reason(v1::BatchRefused::REASON_CONFLICTING_RECORD);
  } else {
    response.mutable_acknowledgement()->set_acknowledged_sequence(AcknowledgedOf(session));
  }
  return response;
}

}  // namespace enfilade::testing
