// SPDX-License-Identifier: Apache-2.0
#pragma once

// The shapes of calls over real gRPC, with handlers that a test writes. No database.
#include <atomic>
#include <functional>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/generic/generic_stub.h"
#include "grpcpp/server_builder.h"
#include "server/rpc/call/client_stream.h"
#include "server/rpc/call/request_id.h"
#include "server/rpc/call/server_stream.h"
#include "server/rpc/call/unary.h"
#include "server/rpc/call/watch_stream.h"
#include "tests/support/test_data.h"
#include "tests/unit/server/rpc/call/call_fixture.h"

namespace enfilade::server {

using GetGraph = std::function<absl::Status(const Call&, const v1::GetGraphRequest&, v1::GetGraphResponse&)>;
using ExportGraph =
    std::function<absl::StatusOr<MessageSource<v1::ExportGraphResponse>>(const Call&, const v1::ExportGraphRequest&)>;
using WatchPoses =
    std::function<absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>>(const Call&, const v1::WatchGlobalPosesRequest&)>;
using ExportMap =
    std::function<absl::StatusOr<MessageSource<grpc::ByteBuffer>>(const Call&, const v1::ExportMapRequest&)>;

// What a client stream's handler was given.
struct Taken {
  std::vector<std::string> parents;
  absl::Status take;    // of the next Take()
  absl::Status answer;  // of Answer()
  std::string actor;    // of the call at Answer()
};

class Taker {
 public:
  explicit Taker(Taken& taken) : taken_(taken) {}

  absl::Status Take(const v1::ImportMapRequest& request) {
    taken_.parents.push_back(request.manifest().parent());
    return taken_.take;
  }
  absl::Status Answer(const storage::CallContext& context, v1::ImportMapResponse& response) {
    taken_.actor = context.actor;
    response.add_warnings(std::to_string(taken_.parents.size()));
    return taken_.answer;
  }

 private:
  Taken& taken_;
};

class GraphService final : public v1::GraphService::CallbackService {
 public:
  explicit GraphService(const CallEnvironment& environment) : environment_(environment) {}

  grpc::ServerUnaryReactor* GetGraph(grpc::CallbackServerContext* context, const v1::GetGraphRequest* request,
                                     v1::GetGraphResponse* response) override {
    return RunUnary(
        CallEntry{environment_, "GetGraph", *context}, request, response, get,
        [this](const v1::GetGraphRequest&, v1::GetGraphResponse& now) -> std::optional<absl::Status> {
          if (version_at_hand == 0) return std::nullopt;
          now.mutable_graph()->set_graph_version(version_at_hand);
          return absl::OkStatus();
        },
        CallTurn{.before = before, .lane = lane});
  }
  grpc::ServerWriteReactor<v1::ExportGraphResponse>* ExportGraph(grpc::CallbackServerContext* context,
                                                                 const v1::ExportGraphRequest* request) override {
    const auto open_now = [this](const Call& call, const v1::ExportGraphRequest& given,
                                 Opened<v1::ExportGraphResponse> opened) { opened(open(call, given)); };
    return RunServerStream<v1::ExportGraphResponse>(CallEntry{environment_, "ExportGraph", *context}, request, open_now,
                                                    {.before = before, .lane = lane});
  }
  grpc::ServerWriteReactor<v1::WatchGlobalPosesResponse>* WatchGlobalPoses(
      grpc::CallbackServerContext* context, const v1::WatchGlobalPosesRequest* request) override {
    return RunWatch<v1::WatchGlobalPosesResponse>(CallEntry{environment_, "WatchGlobalPoses", *context}, request,
                                                  watch);
  }

  BeforeCall before;                 // of GetGraph and ExportGraph
  CallLane lane = CallLane::kUsual;  // of the same
  server::GetGraph get;
  std::atomic<std::int64_t> version_at_hand = 0;
  server::ExportGraph open;
  WatchPoses watch;

 private:
  const CallEnvironment& environment_;
};

class MapService final : public v1::MapService::WithRawCallbackMethod_ExportMap<v1::MapService::CallbackService> {
 public:
  explicit MapService(const CallEnvironment& environment) : environment_(environment) {}

  grpc::ServerWriteReactor<grpc::ByteBuffer>* ExportMap(grpc::CallbackServerContext* context,
                                                        const grpc::ByteBuffer* request) override {
    return RunRawServerStream<v1::ExportMapRequest>(
        CallEntry{environment_, "ExportMap", *context}, request,
        [this](const Call& call, const v1::ExportMapRequest& given, Opened<grpc::ByteBuffer> opened) {
          if (open_later) return open_later(call, given, std::move(opened));
          opened(open(call, given));
        });
  }
  grpc::ServerReadReactor<v1::ImportMapRequest>* ImportMap(grpc::CallbackServerContext* context,
                                                           v1::ImportMapResponse* response) override {
    return RunClientStream<Taker, v1::ImportMapRequest>(CallEntry{environment_, "ImportMap", *context}, response,
                                                        [this] { return Taker(taken); });
  }

  server::ExportMap open;
  std::function<void(const Call&, const v1::ExportMapRequest&, Opened<grpc::ByteBuffer>)> open_later;  // instead
  Taken taken;

 private:
  const CallEnvironment& environment_;
};

class ShapesTest : public CallFixture {
 protected:
  ShapesTest() : graph_(*environment_), map_(*environment_) {
    const std::string address = "unix:" + (directory_.path() / "socket").string();
    grpc::ServerBuilder builder;
    builder.AddListeningPort(address, grpc::InsecureServerCredentials());
    builder.RegisterService(&graph_);
    builder.RegisterService(&map_);
    server_ = builder.BuildAndStart();
    channel_ = grpc::CreateChannel(address, grpc::InsecureChannelCredentials());
    graph_stub_ = v1::GraphService::NewStub(channel_);
    map_stub_ = v1::MapService::NewStub(channel_);
  }
  ~ShapesTest() override { EndServer(); }

  // Cancels what is left. Nothing calls the test's handlers afterwards.
  void EndServer() {
    server_->Shutdown(std::chrono::system_clock::now());
    server_->Wait();
    executor_.Stop();
  }

  // False if it did not come to be in half a minute.
  template <typename Condition>
  static bool Await(const Condition& condition) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!condition()) {
      if (std::chrono::steady_clock::now() > until) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }

  // A handler's wait for its call's cancellation.
  static absl::Status AwaitCancellation(const storage::CallContext& context) {
    if (Await([&context] { return context.cancellation.stop_requested(); })) return absl::CancelledError("stopped");
    return absl::InternalError("was not cancelled");
  }

  static std::string RequestIdIn(const grpc::ClientContext& context) {
    const auto& metadata = context.GetServerInitialMetadata();
    const auto found = metadata.find("x-request-id");
    return found == metadata.end() ? "" : std::string(found->second.data(), found->second.size());
  }

  enfilade::testing::TemporaryDirectory directory_;
  GraphService graph_;
  MapService map_;
  std::unique_ptr<grpc::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::GraphService::Stub> graph_stub_;
  std::unique_ptr<v1::MapService::Stub> map_stub_;
};

}  // namespace enfilade::server
