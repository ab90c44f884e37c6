// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "enfilade/v1/ingest_service.grpc.pb.h"
#include "tests/support/fake_server/fake_server.h"

namespace enfilade::testing {

// The stream of records of a FakeServer.
class FakeServer::Ingest final : public v1::IngestService::Service {
 public:
  explicit Ingest(FakeServer& owner) : owner_(owner) {}

  using Stream = grpc::ServerReaderWriter<v1::StreamRecordsResponse, v1::StreamRecordsRequest>;

  grpc::Status StreamRecords(grpc::ServerContext* context, Stream* stream) override;

 private:
  grpc::Status TakeChunk(const v1::BlobChunk& chunk, std::string& blob);
  void TakePose(Stream& stream, const v1::PoseReport& report);
  grpc::Status TakeBatch(grpc::ServerContext* context, Stream& stream, const std::string& name,
                         const v1::RecordBatch& batch);
  v1::StreamRecordsResponse Store(const std::string& name, const v1::RecordBatch& batch);

  FakeServer& owner_;
};

}  // namespace enfilade::testing
