// SPDX-License-Identifier: Apache-2.0
#include "tests/rpc/server_test.h"

#include <chrono>
#include <thread>

#include "core/base/sha256.h"

namespace enfilade::testing {
namespace {

constexpr double kPatienceS = 60.0;

}  // namespace

server::ServerOptions ServerTest::Options() {
  server::ServerOptions options;
  options.metrics.address = "";
  options.mapping.checkpoint_interval_s = 0.2;
  options.mapping.revision_interval_s = 0.5;
  options.listen.grace_s = 2.0;
  // A survey may cut sessions and move door verdicts while a test looks at them. tests/e2e serves with surveys.
  options.survey.share = 0.0;
  return options;
}

ServerTest::ServerTest() {
  Restart(Options());
  v1::CreateSiteRequest site;
  site.set_site_id("s");
  site.mutable_site()->set_display_name("Site");
  EXPECT_OK(Call(&v1::SiteService::Stub::CreateSite, site));
  v1::CreateRobotRequest robot;
  robot.set_parent("sites/s");
  robot.set_robot_id("r");
  robot.mutable_robot()->set_display_name("Robot");
  EXPECT_OK(Call(&v1::RobotService::Stub::CreateRobot, robot));
  v1::CreateMapRequest map;
  map.set_parent("sites/s");
  map.set_map_id("m");
  map.mutable_map()->set_display_name("Map");
  EXPECT_OK(Call(&v1::MapService::Stub::CreateMap, map));
}

void ServerTest::Restart(const server::ServerOptions& given) {
  server::ServerOptions options = given;
  options.database.url = database_.url();
  options.listen.address = "unix:" + (directory_.path() / "socket").string();
  options.transfers.cache_directory = directory_.path().string();
  server_.reset();
  auto server = server::Server::Start(options, slam::SlamOptions());
  EXPECT_OK(server);
  server_ = *std::move(server);
  connection_ = std::make_unique<client::Connection>(server_->address(), std::chrono::duration<double>(kPatienceS));
  // A first attempt that takes too long on a busy machine would fail the first call.
  EXPECT_TRUE(connection_->channel()->WaitForConnected(std::chrono::system_clock::now() + std::chrono::seconds(60)));
}

std::string ServerTest::CreateSession(bool mapped) {
  v1::CreateSessionRequest request;
  request.set_parent("sites/s");
  request.mutable_session()->set_robot("sites/s/robots/r");
  if (mapped) request.mutable_session()->set_map("sites/s/maps/m");
  const auto response = Call(&v1::SessionService::Stub::CreateSession, request);
  EXPECT_OK(response);
  return response.ok() ? response->session().name() : "";
}

v1::Session ServerTest::GetSession(const std::string& name) const {
  v1::GetSessionRequest request;
  request.set_name(name);
  const auto response = Call(&v1::SessionService::Stub::GetSession, request);
  EXPECT_OK(response);
  return response.ok() ? response->session() : v1::Session();
}

absl::Status ServerTest::FinishSession(const std::string& name, std::int64_t last_sequence) {
  v1::FinishSessionRequest request;
  request.set_name(name);
  request.set_last_sequence(last_sequence);
  return Call(&v1::SessionService::Stub::FinishSession, request).status();
}

void ServerTest::AwaitState(const std::string& name, v1::Session::State state) const {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(kPatienceS);
  v1::Session session;
  while (std::chrono::steady_clock::now() < deadline) {
    session = GetSession(name);
    if (session.state() == state) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  FAIL() << "still waiting: " << session.ShortDebugString();
}

TestStream::TestStream(const client::Connection& connection, const std::string& session)
    : stub_(v1::IngestService::NewStub(connection.channel())), stream_(stub_->StreamRecords(&context_)) {
  v1::StreamRecordsRequest open;
  open.mutable_open()->set_session(session);
  Send(open);
}

TestStream::~TestStream() {
  if (finished_) return;
  context_.TryCancel();
  v1::StreamRecordsResponse ignored;
  while (stream_->Read(&ignored)) {
  }
  stream_->Finish();
}

bool TestStream::SendBatch(const std::vector<v1::Record>& records) {
  v1::StreamRecordsRequest request;
  request.mutable_batch()->mutable_records()->Add(records.begin(), records.end());
  return Send(request);
}

bool TestStream::SendBlob(const std::string& bytes, const std::string& sha256) {
  constexpr std::size_t kChunk = 1U << 20;
  for (std::size_t offset = 0; offset < bytes.size(); offset += kChunk) {
    v1::StreamRecordsRequest request;
    v1::BlobChunk& chunk = *request.mutable_blob_chunk();
    chunk.mutable_blob()->set_sha256(sha256);
    chunk.mutable_blob()->set_size_bytes(static_cast<std::int64_t>(bytes.size()));
    chunk.set_offset(static_cast<std::int64_t>(offset));
    chunk.set_data(bytes.substr(offset, kChunk));
    if (!Send(request)) return false;
  }
  return true;
}

v1::StreamRecordsResponse TestStream::Receive() {
  v1::StreamRecordsResponse response;
  stream_->Read(&response);
  return response;
}

bool TestStream::AwaitAcknowledged(std::int64_t sequence) {
  while (true) {
    const v1::StreamRecordsResponse response = Receive();
    if (response.has_refused() || response.response_case() == v1::StreamRecordsResponse::RESPONSE_NOT_SET) return false;
    if (response.opened().acknowledged_sequence() >= sequence && response.has_opened()) return true;
    if (response.acknowledgement().acknowledged_sequence() >= sequence && response.has_acknowledgement()) return true;
  }
}

absl::Status TestStream::Finish() {
  stream_->WritesDone();
  return AwaitEnd();
}

absl::Status TestStream::AwaitEnd() {
  v1::StreamRecordsResponse ignored;
  while (stream_->Read(&ignored)) {
  }
  finished_ = true;
  return client::FromGrpcStatus(stream_->Finish());
}

v1::Record ScanRecord(std::int64_t sequence) {
  v1::Record record;
  record.set_sequence(sequence);
  v1::LaserScan& scan = *record.mutable_laser_scan();
  scan.mutable_time()->set_seconds(1'700'000'000 + sequence);
  scan.set_angle_min_rad(-1.5);
  scan.set_angle_increment_rad(3.0 / 180.0);
  scan.set_range_max_m(20.0F);
  for (int i = 0; i < 180; ++i) scan.add_ranges_m(2.0F + 0.01F * static_cast<float>((i + sequence) % 90));
  return record;
}

v1::Record OdometryRecord(std::int64_t sequence, double x) {
  v1::Record record;
  record.set_sequence(sequence);
  record.mutable_odometry()->mutable_time()->set_seconds(1'700'000'000 + sequence);
  record.mutable_odometry()->mutable_pose_odom_robot()->set_x(x);
  return record;
}

std::vector<v1::Record> ScanRecords(std::int64_t first, int count) {
  std::vector<v1::Record> records;
  for (int i = 0; i < count; ++i) records.push_back(ScanRecord(first + i));
  return records;
}

}  // namespace enfilade::testing
