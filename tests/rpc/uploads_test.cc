// SPDX-License-Identifier: Apache-2.0
// What uploads under way hold is counted and bounded, whatever call they belong to.
#include <gmock/gmock.h>

#include <deque>

#include "core/base/sha256.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {
namespace {

constexpr std::int64_t kMiB = 1 << 20;
constexpr int kChunks = 3;  // of an upload that its client leaves unfinished

class UploadsTest : public ServerTest {
 protected:
  UploadsTest() {
    server::ServerOptions options = Options();
    options.transfers.upload_memory_bytes = 4 * kMiB;
    options.transfers.upload_disk_bytes = 8 * kMiB;
    options.transfers.upload_directory = directory_.path().string();
    options.database.default_deadline_s = 5.0;
    Restart(options);
  }

  static std::string Part() { return std::string(kMiB, 'x'); }
};

// An import whose file ends after a part, as long as this object is there.
class UnfinishedImport {
 public:
  explicit UnfinishedImport(const client::Connection& connection)
      : stub_(v1::MapService::NewStub(connection.channel())), writer_(stub_->ImportMap(&context_, &response_)) {
    context_.set_wait_for_ready(false);
  }
  ~UnfinishedImport() {
    context_.TryCancel();
    if (!finished_) (void)writer_->Finish();
  }

  void Send() {
    v1::ImportMapRequest request;
    v1::ImportMapManifest& manifest = *request.mutable_manifest();
    manifest.set_parent("sites/s/maps/m");
    v1::FileEntry& file = *manifest.add_files();
    file.set_name("m.pgm");
    file.set_size_bytes(100 * kMiB);
    file.set_sha256(std::string(32, 'x'));
    writer_->Write(request);
    for (int i = 0; i < kChunks; ++i) {
      request.mutable_chunk()->set_offset(i * kMiB);
      request.mutable_chunk()->set_data(std::string(kMiB, 'x'));
      writer_->Write(request);
    }
  }
  // Its end, by the server.
  grpc::Status Finish() {
    finished_ = true;
    return writer_->Finish();
  }
  const grpc::ClientContext& context() const { return context_; }

 private:
  std::unique_ptr<v1::MapService::Stub> stub_;
  grpc::ClientContext context_;
  v1::ImportMapResponse response_;
  std::unique_ptr<grpc::ClientWriter<v1::ImportMapRequest>> writer_;
  bool finished_ = false;
};

TEST_F(UploadsTest, ImportsThatNobodyFinishesFillNoMoreThanTheirSpace) {
  std::deque<UnfinishedImport> imports;
  for (int i = 0; i < 6; ++i) imports.emplace_back(*connection_).Send();
  int refused = 0;
  for (UnfinishedImport& import : imports) {
    const grpc::Status status = import.Finish();
    // Those that have space wait for the rest in vain.
    if (status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED) continue;
    ASSERT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << status.error_message();
    EXPECT_THAT(status.error_message(), ::testing::HasSubstr("transfers.upload_disk_bytes"));
    EXPECT_EQ(import.context().GetServerTrailingMetadata().count("grpc-retry-pushback-ms"), 1U);
    ++refused;
  }
  EXPECT_GE(refused, 1);
}

TEST_F(UploadsTest, BlobsThatNobodyFinishesFillNoMoreThanTheirSpace) {
  const std::string content(static_cast<std::size_t>(60 * kMiB), 'x');
  const std::string sha256 = Sha256(content);
  const auto send_part = [&](TestStream& stream) {
    for (int i = 0; i < kChunks; ++i) {
      v1::StreamRecordsRequest request;
      v1::BlobChunk& chunk = *request.mutable_blob_chunk();
      chunk.mutable_blob()->set_sha256(sha256);
      chunk.mutable_blob()->set_size_bytes(static_cast<std::int64_t>(content.size()));
      chunk.set_offset(i * kMiB);
      chunk.set_data(Part());
      if (!stream.Send(request)) return;
    }
  };
  int accepted = 0;
  {
    std::deque<TestStream> streams;
    for (int i = 0; i < 16; ++i) {
      TestStream& stream = streams.emplace_back(*connection_, CreateSession(false));
      ASSERT_TRUE(stream.Receive().has_opened());
      send_part(stream);
      (void)stream.SendBatch(ScanRecords(1, 1));
    }
    for (TestStream& stream : streams) {
      if (stream.AwaitAcknowledged(1)) {
        ++accepted;
      } else {
        EXPECT_CODE(stream.AwaitEnd(), absl::StatusCode::kResourceExhausted);
      }
    }
  }
  EXPECT_GE(accepted, 1);
  EXPECT_LE(accepted, 2) << "of 3 MiB each: the others did not fit";
  // Their space is free again.
  const std::string small(static_cast<std::size_t>(3 * kMiB), 'y');
  TestStream stream(*connection_, CreateSession(false));
  ASSERT_TRUE(stream.Receive().has_opened());
  ASSERT_TRUE(stream.SendBlob(small, Sha256(small)));
  ASSERT_TRUE(stream.SendBatch(ScanRecords(1, 1)));
  EXPECT_TRUE(stream.AwaitAcknowledged(1));
}

}  // namespace
}  // namespace enfilade::testing
