// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <random>

#include "core/base/sha256.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class IngestTest : public ServerTest {
 protected:
  std::string StoredCount() const { return database_.SqlValue("SELECT count(*) FROM session_records"); }

  // The answer to one batch that must be refused.
  v1::BatchRefused Refused(const std::string& session, const std::vector<v1::Record>& records) {
    TestStream stream(*connection_, session);
    stream.Receive();
    stream.SendBatch(records);
    const v1::StreamRecordsResponse response = stream.Receive();
    EXPECT_TRUE(response.has_refused()) << response.ShortDebugString();
    return response.refused();
  }
};

TEST_F(IngestTest, AcknowledgesWhatIsStoredAndResumesAfterIt) {
  const std::string session = CreateSession(false);
  {
    TestStream stream(*connection_, session);
    EXPECT_EQ(stream.Receive().opened().acknowledged_sequence(), 0);
    ASSERT_TRUE(stream.SendBatch(ScanRecords(1, 100)));
    EXPECT_TRUE(stream.AwaitAcknowledged(100));
    stream.Cancel();
  }
  TestStream stream(*connection_, session);
  EXPECT_EQ(stream.Receive().opened().acknowledged_sequence(), 100);
  ASSERT_TRUE(stream.SendBatch(ScanRecords(51, 100)));  // half of it again
  EXPECT_TRUE(stream.AwaitAcknowledged(150));
  EXPECT_OK(stream.Finish());
  EXPECT_EQ(StoredCount(), "150");
  EXPECT_EQ(GetSession(session).record_counts().laser_scans(), 150);
}

TEST_F(IngestTest, HalfClosedStreamIsAnsweredBeforeItEnds) {
  const std::string session = CreateSession(false);
  TestStream stream(*connection_, session);
  for (int i = 0; i < 20; ++i) stream.SendBatch(ScanRecords(1 + 50 * i, 50));
  EXPECT_OK(stream.Finish());
  EXPECT_EQ(GetSession(session).acknowledged_sequence(), 1000);
}

TEST_F(IngestTest, RefusesABatchWholeNamingTheBadRecordAndGoesOn) {
  const std::string session = CreateSession(false);
  std::vector<v1::Record> records = ScanRecords(1, 10);
  records[6].mutable_laser_scan()->set_angle_increment_rad(NAN);
  TestStream stream(*connection_, session);
  stream.Receive();
  stream.SendBatch(records);
  const v1::BatchRefused refused = stream.Receive().refused();
  EXPECT_EQ(refused.first_sequence(), 1);
  EXPECT_EQ(refused.sequence(), 7);
  EXPECT_EQ(refused.reason(), v1::BatchRefused::REASON_INVALID_RECORD);
  EXPECT_THAT(refused.message(), AllOf(HasSubstr("record 7"), HasSubstr("angle_increment")));
  EXPECT_EQ(StoredCount(), "0");
  stream.SendBatch(ScanRecords(1, 10));
  EXPECT_TRUE(stream.AwaitAcknowledged(10));
}

TEST_F(IngestTest, RefusesWhatNoRecordMayBe) {
  const std::string session = CreateSession(false);
  const auto refused = [&](auto change, const char* message) {
    std::vector<v1::Record> records = ScanRecords(1, 3);
    change(records[1]);
    const v1::BatchRefused answer = Refused(session, records);
    EXPECT_THAT(answer.message(), HasSubstr(message));
  };
  refused([](v1::Record& r) { r.clear_payload(); }, "payload is not set");
  refused([](v1::Record& r) { r.set_sequence(9); }, "increase by one");
  refused([](v1::Record& r) { r.mutable_laser_scan()->clear_ranges_m(); }, "ranges is empty");
  refused([](v1::Record& r) { r.mutable_laser_scan()->mutable_ranges_m()->Resize(200'000, 1.0F); }, "200000 beams");
  refused([](v1::Record& r) { r.mutable_laser_scan()->mutable_time()->set_nanos(-1); }, "time");
  refused(
      [](v1::Record& r) {
        r.mutable_image()->set_camera(static_cast<v1::Image::Camera>(42));
        r.mutable_image()->set_encoding(v1::Image::ENCODING_PNG);
      },
      "image.camera is 42");
  refused(
      [](v1::Record& r) {
        r.mutable_point_cloud()->set_encoding(v1::PointCloud::ENCODING_PCD);
        r.mutable_point_cloud()->mutable_content()->set_sha256(std::string(32, 'x'));
        r.mutable_point_cloud()->mutable_content()->set_size_bytes(5);
      },
      "blob");
  refused([](v1::Record& r) { r.set_sequence(0); }, "increase by one");
  EXPECT_EQ(Refused(session, {}).reason(), v1::BatchRefused::REASON_INVALID_BATCH);
  EXPECT_EQ(StoredCount(), "0");
}

TEST_F(IngestTest, TakesRangesOfEveryKind) {
  const std::string session = CreateSession(false);
  v1::Record record = ScanRecord(1);
  for (const float range : {NAN, -1.0F, INFINITY, -INFINITY, 1e30F}) record.mutable_laser_scan()->add_ranges_m(range);
  TestStream stream(*connection_, session);
  stream.SendBatch({record});
  EXPECT_TRUE(stream.AwaitAcknowledged(1));
}

TEST_F(IngestTest, RefusesOtherContentUnderAStoredSequence) {
  const std::string session = CreateSession(false);
  {
    TestStream stream(*connection_, session);
    stream.SendBatch(ScanRecords(1, 5));
    ASSERT_TRUE(stream.AwaitAcknowledged(5));
  }
  const v1::BatchRefused refused = Refused(session, {ScanRecord(3), OdometryRecord(4, 1.0)});
  EXPECT_EQ(refused.reason(), v1::BatchRefused::REASON_CONFLICTING_RECORD);
  EXPECT_EQ(refused.sequence(), 4);
}

TEST_F(IngestTest, AWithheldRecordTakesTheRefusedOnesPlace) {
  const std::string session = CreateSession(false);
  v1::Record withheld;
  withheld.set_sequence(2);
  withheld.mutable_withheld()->set_reason("angle_increment was NaN");
  TestStream stream(*connection_, session);
  stream.SendBatch({ScanRecord(1), withheld, ScanRecord(3)});
  EXPECT_TRUE(stream.AwaitAcknowledged(3));
  EXPECT_EQ(GetSession(session).record_counts().withheld(), 1);
}

TEST_F(IngestTest, LateDataOfADeletedSessionFail) {
  const std::string session = CreateSession(false);
  TestStream open_before(*connection_, session);
  open_before.Receive();
  v1::DeleteSessionRequest request;
  request.set_name(session);
  ASSERT_OK(Call(&v1::SessionService::Stub::DeleteSession, request));

  open_before.SendBatch(ScanRecords(1, 5));
  EXPECT_CODE(open_before.Finish(), absl::StatusCode::kFailedPrecondition);
  v1::SubmitScanRequest scan;
  scan.set_session(session);
  scan.set_sequence(1);
  *scan.mutable_laser_scan() = ScanRecord(1).laser_scan();
  EXPECT_CODE(Call(&v1::IngestService::Stub::SubmitScan, scan), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(StoredCount(), "0");
}

TEST_F(IngestTest, FiftyReconnectsMakeOneSession) {
  const std::string session = CreateSession(false);
  for (int i = 0; i < 50; ++i) {
    TestStream stream(*connection_, session);
    stream.Receive();
    stream.SendBatch(ScanRecords(1 + 10 * i, 10));
    if (i % 2 == 0) {
      EXPECT_TRUE(stream.AwaitAcknowledged(10 * i + 10));
    } else {
      EXPECT_OK(stream.Finish());
    }
  }
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM sessions"), "1");
  EXPECT_EQ(StoredCount(), "500");
}

// A reader that never reads would otherwise have the server keep all refusals.
TEST_F(IngestTest, AStreamWhoseAnswersAreNotReadIsReadNoFurther) {
  constexpr int kReports = 50'000;
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(8));
  const auto stub = v1::IngestService::NewStub(connection_->channel());
  const auto stream = stub->StreamRecords(&context);
  v1::StreamRecordsRequest request;
  request.mutable_open()->set_session(CreateSession(false));
  ASSERT_TRUE(stream->Write(request));
  v1::StreamRecordsResponse opened;
  ASSERT_TRUE(stream->Read(&opened));
  request.mutable_pose_report()->set_map(std::string(200, 'x'));  // which the refusal repeats
  int sent = 0;
  while (sent < kReports && stream->Write(request)) ++sent;
  EXPECT_LT(sent, kReports) << "flow control stops the sender until the deadline";
  EXPECT_GT(sent, 0);
  while (stream->Read(&opened)) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
}

TEST_F(IngestTest, TheFirstMessageMustOpenASessionThatExists) {
  const auto stub = v1::IngestService::NewStub(connection_->channel());
  const auto status_of = [&](const std::vector<v1::StreamRecordsRequest>& requests) {
    grpc::ClientContext context;
    const auto stream = stub->StreamRecords(&context);
    for (const auto& request : requests) stream->Write(request);
    stream->WritesDone();
    v1::StreamRecordsResponse response;
    while (stream->Read(&response)) {
    }
    return client::FromGrpcStatus(stream->Finish());
  };
  v1::StreamRecordsRequest empty;
  v1::StreamRecordsRequest batch;
  *batch.mutable_batch()->add_records() = ScanRecord(1);
  v1::StreamRecordsRequest unknown;
  unknown.mutable_open()->set_session("sites/s/sessions/unknown");
  v1::StreamRecordsRequest misnamed;
  misnamed.mutable_open()->set_session("'; DROP TABLE sessions; --");
  v1::StreamRecordsRequest good;
  good.mutable_open()->set_session(CreateSession(false));
  EXPECT_CODE(status_of({empty}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(status_of({batch}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(status_of({unknown}), absl::StatusCode::kNotFound);
  EXPECT_CODE(status_of({misnamed}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(status_of({good, good}), absl::StatusCode::kInvalidArgument);
  EXPECT_OK(status_of({good}));
}

TEST_F(IngestTest, UnaryCallsStoreOnceAndCountHoles) {
  const std::string session = CreateSession(false);
  const auto submit = [&](std::int64_t sequence) {
    v1::SubmitScanRequest request;
    request.set_session(session);
    request.set_sequence(sequence);
    *request.mutable_laser_scan() = ScanRecord(sequence).laser_scan();
    return Call(&v1::IngestService::Stub::SubmitScan, request);
  };
  EXPECT_EQ(submit(1)->acknowledged_sequence(), 1);
  EXPECT_EQ(submit(1)->acknowledged_sequence(), 1);
  EXPECT_EQ(submit(3)->acknowledged_sequence(), 1) << "2 is missing";
  EXPECT_EQ(submit(2)->acknowledged_sequence(), 3);
  EXPECT_EQ(StoredCount(), "3");
  v1::SubmitOdometryRequest odometry;
  odometry.set_session(session);
  odometry.set_sequence(4);
  EXPECT_STATUS(Call(&v1::IngestService::Stub::SubmitOdometry, odometry), absl::StatusCode::kInvalidArgument,
                HasSubstr("payload is not set"));
  *odometry.mutable_odometry() = OdometryRecord(4, 2.0).odometry();
  EXPECT_EQ(Call(&v1::IngestService::Stub::SubmitOdometry, odometry)->acknowledged_sequence(), 4);
}

std::string RandomBytes(std::size_t size) {
  std::mt19937_64 rng(size);
  std::string bytes(size, '\0');
  for (std::size_t i = 0; i + 8 <= size; i += 8) {
    const std::uint64_t value = rng();
    std::copy_n(reinterpret_cast<const char*>(&value), 8, &bytes[i]);
  }
  return bytes;
}

TEST_F(IngestTest, A29MegabyteCloudComesBackAsItWent) {
  const std::string session = CreateSession(false);
  const std::string bytes = RandomBytes(29'000'000);
  const std::string sha256 = Sha256(bytes);
  v1::Record record;
  record.set_sequence(1);
  v1::PointCloud& cloud = *record.mutable_point_cloud();
  cloud.mutable_time()->set_seconds(5);
  cloud.set_encoding(v1::PointCloud::ENCODING_XYZ32);
  cloud.mutable_content()->set_sha256(sha256);
  cloud.mutable_content()->set_size_bytes(static_cast<std::int64_t>(bytes.size()));

  TestStream stream(*connection_, session);
  ASSERT_TRUE(stream.SendBlob(bytes, sha256));
  ASSERT_TRUE(stream.SendBatch({record}));
  ASSERT_TRUE(stream.AwaitAcknowledged(1));

  v1::DownloadBlobRequest request;
  request.set_parent("sites/s");
  request.set_sha256(sha256);
  const auto stub = v1::IngestService::NewStub(connection_->channel());
  grpc::ClientContext context;
  const auto reader = stub->DownloadBlob(&context, request);
  v1::DownloadBlobResponse part;
  std::string received;
  while (reader->Read(&part)) {
    EXPECT_LE(part.chunk().data().size(), 1U << 20);
    received += part.chunk().data();
  }
  ASSERT_TRUE(reader->Finish().ok());
  EXPECT_TRUE(received == bytes);
}

TEST_F(IngestTest, UnaryImagesUpTo64MegabytesAreStoredOnce) {
  const std::string session = CreateSession(false);
  v1::SubmitImageRequest request;
  request.set_session(session);
  request.set_sequence(1);
  request.mutable_image()->mutable_time()->set_seconds(5);
  request.mutable_image()->set_camera(v1::Image::CAMERA_FRONT);
  request.mutable_image()->set_encoding(v1::Image::ENCODING_PNG);
  request.set_data(RandomBytes(64U << 20));
  EXPECT_OK(Call(&v1::IngestService::Stub::SubmitImage, request));
  request.set_sequence(2);
  EXPECT_OK(Call(&v1::IngestService::Stub::SubmitImage, request));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM blobs"), "1");
  request.set_sequence(3);
  request.mutable_image()->mutable_content()->set_sha256(std::string(32, 'x'));
  EXPECT_CODE(Call(&v1::IngestService::Stub::SubmitImage, request), absl::StatusCode::kInvalidArgument);
}

TEST_F(IngestTest, RefusesBlobChunksThatDoNotFit) {
  const std::string session = CreateSession(false);
  const std::string bytes(3'000'000, 'a');
  {
    TestStream stream(*connection_, session);
    stream.SendBlob(bytes, Sha256("other"));
    EXPECT_CODE(stream.Finish(), absl::StatusCode::kDataLoss);
  }
  TestStream stream(*connection_, session);
  v1::StreamRecordsRequest request;
  request.mutable_blob_chunk()->mutable_blob()->set_sha256(Sha256(bytes));
  request.mutable_blob_chunk()->mutable_blob()->set_size_bytes(65LL << 20);
  request.mutable_blob_chunk()->set_data("a");
  stream.Send(request);
  EXPECT_STATUS(stream.Finish(), absl::StatusCode::kInvalidArgument, HasSubstr("67108864"));
}

TEST_F(IngestTest, AStreamFarAheadOfTheDatabaseIsSlowedAndLosesNothing) {
  server::ServerOptions options = Options();
  options.ingest.stream_buffer_bytes = 1 << 20;
  options.ingest.total_buffer_bytes = 2 << 20;
  options.ingest.transaction_bytes = 1 << 20;
  Restart(options);
  const std::string session = CreateSession(false);
  const std::string other = CreateSession(false);
  TestStream first(*connection_, session);
  TestStream second(*connection_, other);
  for (int i = 0; i < 60; ++i) {
    ASSERT_TRUE(first.SendBatch(ScanRecords(1 + 400 * i, 400)));
    ASSERT_TRUE(second.SendBatch(ScanRecords(1 + 400 * i, 400)));
  }
  EXPECT_TRUE(first.AwaitAcknowledged(24'000));
  EXPECT_TRUE(second.AwaitAcknowledged(24'000));
  EXPECT_EQ(StoredCount(), "48000");
}

}  // namespace
}  // namespace enfilade::testing
