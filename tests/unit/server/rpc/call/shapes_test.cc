// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/server/rpc/call/shapes_fixture.h"

namespace enfilade::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using ::testing::HasSubstr;

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
  // gRPC sends the time that is left, rounded up.
  EXPECT_LE(context.deadline, steady_clock::now() + seconds(12)) << "not the default of 30 s";
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

// The executor has one thread.
TEST_F(ShapesTest, CallsThatWaitBeforeTheirTurnHoldNoThread) {
  std::vector<std::function<void(const absl::Status&)>> waiting;
  std::mutex mutex;
  const auto count = [&] {
    const std::lock_guard lock(mutex);
    return waiting.size();
  };
  graph_.before = [&](const Call&, std::function<void(const absl::Status&)> next) {
    const std::lock_guard lock(mutex);
    waiting.push_back(std::move(next));
  };
  graph_.get = [](const Call&, const v1::GetGraphRequest&, v1::GetGraphResponse&) { return absl::OkStatus(); };
  map_.open = [](const Call&, const v1::ExportMapRequest&) {
    return MessageSource<grpc::ByteBuffer>([](grpc::ByteBuffer&) { return absl::StatusOr<bool>(false); });
  };
  std::vector<std::thread> callers;
  std::atomic<int> refused{0};
  for (int i = 0; i < 6; ++i) {
    callers.emplace_back([&] {
      grpc::ClientContext client;
      v1::GetGraphResponse response;
      if (graph_stub_->GetGraph(&client, {}, &response).error_message() == "cannot be read") ++refused;
    });
  }
  ASSERT_TRUE(Await([&] { return count() == 6; }));
  grpc::ClientContext client;
  const auto stream = map_stub_->ExportMap(&client, {});
  v1::ExportMapResponse message;
  EXPECT_FALSE(stream->Read(&message));
  EXPECT_TRUE(stream->Finish().ok()) << "another call has its turn";
  for (std::size_t i = 0; i < 6; ++i) waiting[i](i < 2 ? absl::UnavailableError("cannot be read") : absl::OkStatus());
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(refused, 2);
}

// The only thread of the executor is busy.
TEST_F(ShapesTest, LargeAnswersAreMadeByThreadsOfTheirOwn) {
  Executor bulk(1, 100);
  environment_->bulk = &bulk;
  graph_.lane = CallLane::kBulk;
  graph_.get = [](const Call&, const v1::GetGraphRequest&, v1::GetGraphResponse&) { return absl::OkStatus(); };
  graph_.open = [](const Call&, const v1::ExportGraphRequest&) {
    return MessageSource<v1::ExportGraphResponse>([](v1::ExportGraphResponse&) { return absl::StatusOr<bool>(false); });
  };
  std::promise<void> end;
  ASSERT_TRUE(executor_.Post([&] { end.get_future().wait(); }));
  grpc::ClientContext client;
  client.set_deadline(std::chrono::system_clock::now() + seconds(20));
  v1::GetGraphResponse response;
  EXPECT_TRUE(graph_stub_->GetGraph(&client, {}, &response).ok());
  grpc::ClientContext streaming;
  streaming.set_deadline(std::chrono::system_clock::now() + seconds(20));
  const auto stream = graph_stub_->ExportGraph(&streaming, {});
  v1::ExportGraphResponse message;
  EXPECT_FALSE(stream->Read(&message));
  EXPECT_TRUE(stream->Finish().ok());
  end.set_value();
  EndServer();
}

TEST_F(ShapesTest, AStreamThatIsOpenedLaterHoldsNoThreadMeanwhile) {
  std::promise<std::function<void()>> open_now;
  map_.open_later = [&](const Call& call, const v1::ExportMapRequest&, Opened<grpc::ByteBuffer> opened) {
    open_now.set_value([&call, opened = std::move(opened)] {
      call.Continue([opened] { opened(absl::NotFoundError("no such map")); });
    });
  };
  graph_.get = [](const Call&, const v1::GetGraphRequest&, v1::GetGraphResponse&) { return absl::OkStatus(); };
  grpc::ClientContext client;
  const auto stream = map_stub_->ExportMap(&client, {});
  const auto open = open_now.get_future().get();
  grpc::ClientContext other;
  v1::GetGraphResponse response;
  EXPECT_TRUE(graph_stub_->GetGraph(&other, {}, &response).ok());
  open();
  v1::ExportMapResponse message;
  EXPECT_FALSE(stream->Read(&message));
  EXPECT_EQ(stream->Finish().error_message(), "no such map");
}

// The executor has one thread, and the client reads as fast as it can.
TEST_F(ShapesTest, AnEndlessStreamLeavesOtherCallsTheirTurn) {
  graph_.open = [](const Call&, const v1::ExportGraphRequest&) {
    return MessageSource<v1::ExportGraphResponse>([](v1::ExportGraphResponse& message) -> absl::StatusOr<bool> {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // sending is faster than making
      message.mutable_chunk()->set_data("x");
      return true;
    });
  };
  graph_.get = [](const Call&, const v1::GetGraphRequest&, v1::GetGraphResponse&) { return absl::OkStatus(); };
  grpc::ClientContext endless;
  const auto stream = graph_stub_->ExportGraph(&endless, {});
  std::thread reader([&] {
    v1::ExportGraphResponse message;
    while (stream->Read(&message)) {
    }
  });
  for (int i = 0; i < 10; ++i) {
    grpc::ClientContext client;
    client.set_deadline(std::chrono::system_clock::now() + seconds(20));
    v1::GetGraphResponse response;
    EXPECT_TRUE(graph_stub_->GetGraph(&client, {}, &response).ok());
  }
  endless.TryCancel();
  reader.join();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
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
  client.AddMetadata("enfilade-actor", "ann");
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
  EXPECT_EQ(map_.taken.actor, "ann");
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

}  // namespace
}  // namespace enfilade::server
