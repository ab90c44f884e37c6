// SPDX-License-Identifier: Apache-2.0
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
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using ::testing::HasSubstr;

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
  std::string site;     // of the call at Answer()
};

class Taker {
 public:
  Taker(const Call& call, Taken& taken) : call_(call), taken_(taken) {}

  absl::Status Take(const v1::ImportMapRequest& request) {
    taken_.parents.push_back(request.manifest().parent());
    return taken_.take;
  }
  absl::Status Answer(v1::ImportMapResponse& response) {
    taken_.site = call_.site();
    response.add_warnings(std::to_string(taken_.parents.size()));
    return taken_.answer;
  }

 private:
  const Call& call_;
  Taken& taken_;
};

class GraphService final : public v1::GraphService::CallbackService {
 public:
  explicit GraphService(const CallEnvironment& environment) : environment_(environment) {}

  grpc::ServerUnaryReactor* GetGraph(grpc::CallbackServerContext* context, const v1::GetGraphRequest* request,
                                     v1::GetGraphResponse* response) override {
    return RunUnary(CallEntry{environment_, "GetGraph", *context}, request, response, get,
                    [this](const v1::GetGraphRequest&, v1::GetGraphResponse& now) -> std::optional<absl::Status> {
                      if (version_at_hand == 0) return std::nullopt;
                      now.mutable_graph()->set_graph_version(version_at_hand);
                      return absl::OkStatus();
                    });
  }
  grpc::ServerWriteReactor<v1::ExportGraphResponse>* ExportGraph(grpc::CallbackServerContext* context,
                                                                 const v1::ExportGraphRequest* request) override {
    return RunServerStream<v1::ExportGraphResponse>(CallEntry{environment_, "ExportGraph", *context}, request, open);
  }
  grpc::ServerWriteReactor<v1::WatchGlobalPosesResponse>* WatchGlobalPoses(
      grpc::CallbackServerContext* context, const v1::WatchGlobalPosesRequest* request) override {
    return RunWatch<v1::WatchGlobalPosesResponse>(CallEntry{environment_, "WatchGlobalPoses", *context}, request,
                                                  watch);
  }

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
    return RunRawServerStream<v1::ExportMapRequest>(CallEntry{environment_, "ExportMap", *context}, request, open);
  }
  grpc::ServerReadReactor<v1::ImportMapRequest>* ImportMap(grpc::CallbackServerContext* context,
                                                           v1::ImportMapResponse* response) override {
    return RunClientStream<Taker, v1::ImportMapRequest>(CallEntry{environment_, "ImportMap", *context}, response,
                                                        [this](const Call& call) { return Taker(call, taken); });
  }

  server::ExportMap open;
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
    const auto until = steady_clock::now() + seconds(30);
    while (!condition()) {
      if (steady_clock::now() > until) return false;
      std::this_thread::sleep_for(milliseconds(1));
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

TEST_F(ShapesTest, UnaryHandlersSeeTheCallAsTheClientMadeIt) {
  std::string seen;
  storage::CallContext context;
  graph_.get = [&](const Call& call, const v1::GetGraphRequest& request, v1::GetGraphResponse& response) {
    seen = call.principal().name + " " + call.site() + " " + call.rpc();
    context = call.context();
    response.mutable_graph()->set_graph_version(request.graph_version() + 1);
    return absl::OkStatus();
  };
  v1::GetGraphRequest request;
  request.set_site("sites/hq");
  request.set_graph_version(6);
  v1::GetGraphResponse response;
  grpc::ClientContext client;
  client.AddMetadata("enfilade-actor", "ann");
  client.set_deadline(std::chrono::system_clock::now() + seconds(10));
  ASSERT_TRUE(graph_stub_->GetGraph(&client, request, &response).ok());
  EXPECT_EQ(response.graph().graph_version(), 7);
  EXPECT_EQ(seen, "ann hq GetGraph");
  EXPECT_LE(context.deadline, steady_clock::now() + seconds(10)) << "not the default of 30 s";
  EXPECT_EQ(context.actor, "ann");
}

TEST_F(ShapesTest, UnaryAnswersCarryTheRequestIdWhateverTheOutcome) {
  absl::Status outcome;
  graph_.get = [&](const Call&, const v1::GetGraphRequest&, v1::GetGraphResponse&) { return outcome; };
  for (const absl::Status& status : {absl::OkStatus(), absl::NotFoundError("no such site")}) {
    outcome = status;
    v1::GetGraphResponse response;
    grpc::ClientContext with_id;
    with_id.AddMetadata("x-request-id", "job-17");
    EXPECT_EQ(graph_stub_->GetGraph(&with_id, {}, &response).ok(), status.ok());
    EXPECT_EQ(RequestIdIn(with_id), "job-17");
    grpc::ClientContext without_id;
    EXPECT_EQ(graph_stub_->GetGraph(&without_id, {}, &response).error_message(), status.message());
    EXPECT_TRUE(IsValidRequestId(RequestIdIn(without_id)));
  }
  EXPECT_THAT(Log(), HasSubstr("GetGraph failed"));
  EXPECT_THAT(Log(), HasSubstr("request job-17"));
}

TEST_F(ShapesTest, UnaryAnswersAtHandNeedNoExecutor) {
  graph_.get = [](const Call&, const v1::GetGraphRequest&, v1::GetGraphResponse&) {
    return absl::InternalError("asked although the answer was at hand");
  };
  graph_.version_at_hand = 3;
  executor_.Stop();
  v1::GetGraphResponse response;
  grpc::ClientContext client;
  client.AddMetadata("x-request-id", "quick");
  ASSERT_TRUE(graph_stub_->GetGraph(&client, {}, &response).ok());
  EXPECT_EQ(response.graph().graph_version(), 3);
  EXPECT_EQ(RequestIdIn(client), "quick");
}

TEST_F(ShapesTest, ACancelledUnaryCallCancelsItsHandler) {
  const auto ended = std::make_shared<std::promise<absl::Status>>();
  grpc::ClientContext client;
  graph_.get = [&client, ended](const Call& call, const v1::GetGraphRequest&, v1::GetGraphResponse&) {
    client.TryCancel();
    const absl::Status status = AwaitCancellation(call.context());
    ended->set_value(status);
    return status;
  };
  v1::GetGraphResponse response;
  EXPECT_EQ(graph_stub_->GetGraph(&client, {}, &response).error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_CODE(ended->get_future().get(), absl::StatusCode::kCancelled);
}

TEST_F(ShapesTest, AUnaryCallsDeadlineCancelsItsHandler) {
  const auto ended = std::make_shared<std::promise<absl::Status>>();
  graph_.get = [ended](const Call& call, const v1::GetGraphRequest&, v1::GetGraphResponse&) {
    const absl::Status status = AwaitCancellation(call.context());
    ended->set_value(status);
    return status;
  };
  grpc::ClientContext client;
  client.set_deadline(std::chrono::system_clock::now() + milliseconds(200));
  v1::GetGraphResponse response;
  EXPECT_EQ(graph_stub_->GetGraph(&client, {}, &response).error_code(), grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_CODE(ended->get_future().get(), absl::StatusCode::kCancelled);
}

TEST_F(ShapesTest, ServerStreamsSendWhatTheSourceMakesInOrder) {
  for (const int count : {0, 1, 3, 4, 5, 100}) {
    graph_.open = [count](const Call&, const v1::ExportGraphRequest&) {
      return MessageSource<v1::ExportGraphResponse>([count, next = 0](v1::ExportGraphResponse& message) mutable {
        if (next == count) return absl::StatusOr<bool>(false);
        message.mutable_chunk()->set_offset(next++);
        return absl::StatusOr<bool>(true);
      });
    };
    grpc::ClientContext client;
    const auto stream = graph_stub_->ExportGraph(&client, {});
    v1::ExportGraphResponse message;
    int received = 0;
    while (stream->Read(&message)) EXPECT_EQ(message.chunk().offset(), received++);
    EXPECT_TRUE(stream->Finish().ok());
    EXPECT_EQ(received, count);
  }
}

TEST_F(ShapesTest, ServerStreamsEndWithTheErrorOfTheirSourceAfterWhatItMade) {
  graph_.open = [](const Call&, const v1::ExportGraphRequest&) {
    return MessageSource<v1::ExportGraphResponse>(
        [next = 0](v1::ExportGraphResponse& message) mutable -> absl::StatusOr<bool> {
          if (next == 6) return absl::DataLossError("the file has become shorter");
          message.mutable_chunk()->set_offset(next++);
          return true;
        });
  };
  grpc::ClientContext client;
  const auto stream = graph_stub_->ExportGraph(&client, {});
  v1::ExportGraphResponse message;
  int received = 0;
  while (stream->Read(&message)) ++received;
  EXPECT_EQ(received, 6);
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::DATA_LOSS);
}

TEST_F(ShapesTest, ServerStreamsThatCannotBeOpenedSayWhyAndWhere) {
  graph_.open = [](const Call&,
                   const v1::ExportGraphRequest&) -> absl::StatusOr<MessageSource<v1::ExportGraphResponse>> {
    return absl::NotFoundError("no such site");
  };
  v1::ExportGraphRequest request;
  request.set_site("sites/hq");
  grpc::ClientContext client;
  client.AddMetadata("x-request-id", "export-1");
  const auto stream = graph_stub_->ExportGraph(&client, request);
  v1::ExportGraphResponse message;
  EXPECT_FALSE(stream->Read(&message));
  EXPECT_EQ(stream->Finish().error_message(), "no such site");
  EXPECT_EQ(RequestIdIn(client), "export-1");
  EXPECT_THAT(Log(), HasSubstr("(request export-1"));
  EXPECT_THAT(Log(), HasSubstr("site \"hq\""));
}

TEST_F(ShapesTest, ACancelledServerStreamLetsItsEndlessSourceGo) {
  const auto destroyed = std::make_shared<std::promise<void>>();
  graph_.open = [destroyed](const Call&, const v1::ExportGraphRequest&) {
    const auto guard = std::shared_ptr<void>(nullptr, [destroyed](void*) { destroyed->set_value(); });
    return MessageSource<v1::ExportGraphResponse>([guard](v1::ExportGraphResponse& message) -> absl::StatusOr<bool> {
      message.mutable_chunk()->set_data(std::string(64 << 10, 'x'));
      return true;
    });
  };
  grpc::ClientContext client;
  const auto stream = graph_stub_->ExportGraph(&client, {});
  v1::ExportGraphResponse message;
  ASSERT_TRUE(stream->Read(&message));
  client.TryCancel();
  while (stream->Read(&message)) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_EQ(destroyed->get_future().wait_for(seconds(30)), std::future_status::ready);
}

TEST_F(ShapesTest, RawServerStreamsDecodeTheRequestAndRefuseWhatIsNone) {
  map_.open = [](const Call& call, const v1::ExportMapRequest& request) {
    return MessageSource<grpc::ByteBuffer>([text = call.site() + "|" + request.name(),
                                            sent = false](grpc::ByteBuffer& bytes) mutable -> absl::StatusOr<bool> {
      if (std::exchange(sent, true)) return false;
      v1::ExportMapResponse message;
      message.mutable_chunk()->set_data(text);
      const grpc::Slice slice(message.SerializeAsString());
      bytes = grpc::ByteBuffer(&slice, 1);
      return true;
    });
  };
  v1::ExportMapRequest request;
  request.set_name("sites/hq/maps/m");
  grpc::ClientContext client;
  const auto stream = map_stub_->ExportMap(&client, request);
  v1::ExportMapResponse message;
  ASSERT_TRUE(stream->Read(&message));
  EXPECT_EQ(message.chunk().data(), "hq|sites/hq/maps/m");
  EXPECT_FALSE(stream->Read(&message));
  EXPECT_TRUE(stream->Finish().ok());

  grpc::GenericStub generic(channel_);
  grpc::ClientContext garbled;
  grpc::CompletionQueue queue;
  const grpc::Slice slice(std::string("\x0A\xFFnot a message"));
  const auto call = generic.PrepareCall(&garbled, "/enfilade.v1.MapService/ExportMap", &queue);
  void* tag = nullptr;
  bool ok = false;
  call->StartCall(nullptr);
  queue.Next(&tag, &ok);
  call->WriteLast(grpc::ByteBuffer(&slice, 1), grpc::WriteOptions(), nullptr);
  queue.Next(&tag, &ok);
  grpc::Status status;
  call->Finish(&status, nullptr);
  queue.Next(&tag, &ok);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(ShapesTest, ClientStreamsGiveEachMessageToTheHandlerAndThenItsAnswer) {
  v1::ImportMapResponse response;
  grpc::ClientContext client;
  const auto stream = map_stub_->ImportMap(&client, &response);
  for (const char* parent : {"sites/hq/maps/m", "sites/other/maps/m", ""}) {
    v1::ImportMapRequest request;
    request.mutable_manifest()->set_parent(parent);
    ASSERT_TRUE(stream->Write(request));
  }
  stream->WritesDone();
  ASSERT_TRUE(stream->Finish().ok());
  EXPECT_EQ(response.warnings(0), "3");
  EXPECT_EQ(map_.taken.parents, (std::vector<std::string>{"sites/hq/maps/m", "sites/other/maps/m", ""}));
  EXPECT_EQ(map_.taken.site, "hq") << "of the first message that names one";
}

TEST_F(ShapesTest, ClientStreamsMayBeEmpty) {
  v1::ImportMapResponse response;
  grpc::ClientContext client;
  const auto stream = map_stub_->ImportMap(&client, &response);
  stream->WritesDone();
  ASSERT_TRUE(stream->Finish().ok());
  EXPECT_EQ(response.warnings(0), "0");
}

TEST_F(ShapesTest, ClientStreamsEndAtTheFirstMessageThatTheHandlerRefuses) {
  map_.taken.take = absl::InvalidArgumentError("expected the manifest");
  v1::ImportMapResponse response;
  grpc::ClientContext client;
  client.AddMetadata("x-request-id", "import-1");
  const auto stream = map_stub_->ImportMap(&client, &response);
  while (stream->Write({})) {
  }
  EXPECT_EQ(stream->Finish().error_message(), "expected the manifest");
  EXPECT_EQ(map_.taken.parents.size(), 1U);
  EXPECT_EQ(RequestIdIn(client), "import-1");
}

TEST_F(ShapesTest, ClientStreamsEndWithTheErrorOfTheAnswer) {
  map_.taken.answer = absl::DataLossError("another digest");
  v1::ImportMapResponse response;
  grpc::ClientContext client;
  const auto stream = map_stub_->ImportMap(&client, &response);
  stream->WritesDone();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::DATA_LOSS);
}

class WatchTest : public ShapesTest {
 protected:
  ~WatchTest() override { EndServer(); }

  // A watch whose every third check finds something: the number of the check.
  Watch<v1::WatchGlobalPosesResponse> EveryThird(steady_clock::duration period) {
    return {.period = period,
            .check =
                [this](const storage::CallContext& context, v1::WatchGlobalPosesResponse& message) {
                  last_context_ = context;
                  const int check = ++checks_;
                  message.set_graph_version(check);
                  return absl::StatusOr<bool>(check % 3 == 1);
                },
            .stopping = [this] { return stopping_.load(); }};
  }

  std::atomic<int> checks_ = 0;
  std::atomic<bool> stopping_ = false;
  storage::CallContext last_context_;  // written by the executor's thread; read after EndServer()
};

TEST_F(WatchTest, SendsOnlyWhatTheChecksFind) {
  graph_.watch = [this](const Call&, const v1::WatchGlobalPosesRequest&) {
    return absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>>(EveryThird(milliseconds(1)));
  };
  grpc::ClientContext client;
  client.AddMetadata("enfilade-actor", "ann");
  const auto stream = graph_stub_->WatchGlobalPoses(&client, {});
  v1::WatchGlobalPosesResponse message;
  for (const int expected : {1, 4, 7}) {
    ASSERT_TRUE(stream->Read(&message));
    EXPECT_EQ(message.graph_version(), expected);
  }
  stopping_ = true;
  while (stream->Read(&message)) {
  }
  const grpc::Status status = stream->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_THAT(status.error_message(), HasSubstr("call again"));
  EndServer();
  EXPECT_EQ(last_context_.actor, "ann");
}

TEST_F(WatchTest, ChecksOncePerPeriod) {
  graph_.watch = [this](const Call&, const v1::WatchGlobalPosesRequest&) {
    return absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>>(EveryThird(std::chrono::hours(1)));
  };
  grpc::ClientContext client;
  const auto stream = graph_stub_->WatchGlobalPoses(&client, {});
  v1::WatchGlobalPosesResponse message;
  ASSERT_TRUE(stream->Read(&message));
  stopping_ = true;  // noticed without another check
  EXPECT_FALSE(stream->Read(&message));
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(checks_, 1);
}

TEST_F(WatchTest, GivesEachCheckTheDefaultTimeout) {
  environment_->default_timeout = milliseconds(50);
  const auto late = std::make_shared<std::atomic<int>>(0);
  graph_.watch = [this, late](const Call&, const v1::WatchGlobalPosesRequest&) {
    Watch<v1::WatchGlobalPosesResponse> watch = EveryThird(milliseconds(20));
    watch.check = [late, check = watch.check](const storage::CallContext& context,
                                              v1::WatchGlobalPosesResponse& message) {
      if (context.deadline < steady_clock::now() - seconds(5)) ++*late;
      return check(context, message);
    };
    return absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>>(watch);
  };
  grpc::ClientContext client;
  const auto stream = graph_stub_->WatchGlobalPoses(&client, {});
  v1::WatchGlobalPosesResponse message;
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(stream->Read(&message)) << "the stream outlives the timeout of a call";
  client.TryCancel();
  while (stream->Read(&message)) {
  }
  stream->Finish();
  EXPECT_EQ(*late, 0);
}

TEST_F(WatchTest, AClientThatGoesCancelsTheCheckAndEndsTheWatch) {
  const auto ended = std::make_shared<std::promise<absl::Status>>();
  grpc::ClientContext client;
  graph_.watch = [this, &client, ended](const Call&, const v1::WatchGlobalPosesRequest&) {
    Watch<v1::WatchGlobalPosesResponse> watch = EveryThird(milliseconds(1));
    watch.check = [&client, ended](const storage::CallContext& context,
                                   v1::WatchGlobalPosesResponse&) -> absl::StatusOr<bool> {
      client.TryCancel();
      const absl::Status status = AwaitCancellation(context);
      ended->set_value(status);
      return status;
    };
    return absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>>(watch);
  };
  const auto stream = graph_stub_->WatchGlobalPoses(&client, {});
  v1::WatchGlobalPosesResponse message;
  EXPECT_FALSE(stream->Read(&message));
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  EXPECT_CODE(ended->get_future().get(), absl::StatusCode::kCancelled);
}

TEST_F(WatchTest, EndsWithTheErrorOfItsOpeningOrOfACheck) {
  graph_.watch = [](const Call& call,
                    const v1::WatchGlobalPosesRequest&) -> absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>> {
    return absl::InvalidArgumentError("not of " + call.site());
  };
  v1::WatchGlobalPosesRequest request;
  request.set_parent("sites/hq");
  v1::WatchGlobalPosesResponse message;
  grpc::ClientContext first;
  const auto refused = graph_stub_->WatchGlobalPoses(&first, request);
  EXPECT_FALSE(refused->Read(&message));
  EXPECT_EQ(refused->Finish().error_message(), "not of hq");

  graph_.watch = [this](const Call&, const v1::WatchGlobalPosesRequest&) {
    Watch<v1::WatchGlobalPosesResponse> watch = EveryThird(milliseconds(1));
    watch.check = [check = watch.check](const storage::CallContext& context,
                                        v1::WatchGlobalPosesResponse& response) -> absl::StatusOr<bool> {
      const absl::StatusOr<bool> changed = check(context, response);
      if (response.graph_version() == 2) return absl::NotFoundError("the site has been deleted");
      return changed;
    };
    return absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>>(watch);
  };
  grpc::ClientContext second;
  const auto broken = graph_stub_->WatchGlobalPoses(&second, request);
  EXPECT_TRUE(broken->Read(&message));
  EXPECT_FALSE(broken->Read(&message));
  EXPECT_EQ(broken->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
}

}  // namespace
}  // namespace enfilade::server
