// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/sdk/connection.h"
#include "enfilade/v1/ingest_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/robot_service.grpc.pb.h"
#include "enfilade/v1/server_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "grpcpp/grpcpp.h"
#include "server/server.h"
#include "tests/support/database.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::testing {

// The whole server in this process over a database of its own, called through gRPC over a Unix socket. Site "s", robot
// "r" and map "m" exist.
class ServerTest : public DatabaseTest {
 protected:
  ServerTest();

  static server::ServerOptions Options();
  void Restart(const server::ServerOptions& options);

  template <typename Service, typename Request, typename Response>
  absl::StatusOr<Response> Call(grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
                                const Request& request) const {
    return connection_->Call(method, request);
  }

  // A new session of robot "r", into map "m" or only recorded. Gives its resource name.
  std::string CreateSession(bool mapped);
  v1::Session GetSession(const std::string& name) const;
  absl::Status FinishSession(const std::string& name, std::int64_t last_sequence);
  // Until its state is `state`; fails the test where it takes too long.
  void AwaitState(const std::string& name, v1::Session::State state) const;

  TemporaryDirectory directory_;
  std::unique_ptr<server::Server> server_;
  std::unique_ptr<client::Connection> connection_;
};

// A stream of records, spoken by hand.
class TestStream {
 public:
  TestStream(const client::Connection& connection, const std::string& session);
  // Cancels what is still open.
  ~TestStream();

  bool Send(const v1::StreamRecordsRequest& request) { return stream_->Write(request); }
  bool SendBatch(const std::vector<v1::Record>& records);
  bool SendBlob(const std::string& bytes, const std::string& sha256);
  // The next answer; a default one at the end of the stream.
  v1::StreamRecordsResponse Receive();
  // Reads until the sequence is acknowledged. False where the stream ends before or refuses.
  bool AwaitAcknowledged(std::int64_t sequence);
  // Half-closes and gives the stream's status after the remaining answers.
  absl::Status Finish();
  // The same without half-closing: it is for the server to end the stream.
  absl::Status AwaitEnd();
  void Cancel() { context_.TryCancel(); }

 private:
  std::unique_ptr<v1::IngestService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamRecordsRequest, v1::StreamRecordsResponse>> stream_;
  bool finished_ = false;
};

v1::Record ScanRecord(std::int64_t sequence);
v1::Record OdometryRecord(std::int64_t sequence, double x);
// Scans first, first + 1, ..., first + count - 1.
std::vector<v1::Record> ScanRecords(std::int64_t first, int count);

}  // namespace enfilade::testing
