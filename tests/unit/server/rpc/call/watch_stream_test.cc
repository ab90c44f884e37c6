// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/server/rpc/call/shapes_fixture.h"

namespace enfilade::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using ::testing::HasSubstr;

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

TEST_F(WatchTest, ChecksOnlyWhereALookFindsNews) {
  std::atomic<int> looks = 0;
  graph_.watch = [&](const Call&, const v1::WatchGlobalPosesRequest&) {
    Watch<v1::WatchGlobalPosesResponse> watch = EveryThird(milliseconds(1));
    watch.look = [&](const std::function<void(const absl::StatusOr<bool>&)>& then) {
      const int look = ++looks;
      if (look == 100) return then(absl::NotFoundError("the site is gone"));
      then(look % 10 == 0);
    };
    return absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>>(watch);
  };
  grpc::ClientContext client;
  const auto stream = graph_stub_->WatchGlobalPoses(&client, {});
  v1::WatchGlobalPosesResponse message;
  while (stream->Read(&message)) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(checks_, 9);
}

TEST_F(WatchTest, OpensInItsTurnOrNotAtAll) {
  graph_.watch = [this](const Call&, const v1::WatchGlobalPosesRequest&) {
    Watch<v1::WatchGlobalPosesResponse> watch = EveryThird(milliseconds(1));
    watch.open = [](const storage::CallContext&) { return absl::NotFoundError("no such robot"); };
    return absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>>(watch);
  };
  grpc::ClientContext client;
  const auto stream = graph_stub_->WatchGlobalPoses(&client, {});
  v1::WatchGlobalPosesResponse message;
  EXPECT_FALSE(stream->Read(&message));
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(checks_, 0);
}

TEST_F(WatchTest, SendsTheRestOfAMessageAtOnce) {
  graph_.watch = [this](const Call&, const v1::WatchGlobalPosesRequest&) {
    Watch<v1::WatchGlobalPosesResponse> watch = EveryThird(std::chrono::hours(1));
    watch.check = [this](const storage::CallContext&, v1::WatchGlobalPosesResponse& message) {
      message.set_graph_version(++checks_);
      return absl::StatusOr<bool>(true);
    };
    watch.has_more = [this] { return checks_ < 5; };
    return absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>>(watch);
  };
  grpc::ClientContext client;
  const auto stream = graph_stub_->WatchGlobalPoses(&client, {});
  v1::WatchGlobalPosesResponse message;
  for (int part = 1; part <= 5; ++part) {
    ASSERT_TRUE(stream->Read(&message));
    EXPECT_EQ(message.graph_version(), part);
  }
  client.TryCancel();
  EXPECT_FALSE(stream->Read(&message));
  EXPECT_EQ(checks_, 5);
}

// So a slow reader costs one message, and gets the latest once it reads on.
TEST_F(WatchTest, ChecksNothingWhileTheClientDoesNotRead) {
  graph_.watch = [this](const Call&, const v1::WatchGlobalPosesRequest&) {
    Watch<v1::WatchGlobalPosesResponse> watch = EveryThird(milliseconds(1));
    watch.check = [this](const storage::CallContext&, v1::WatchGlobalPosesResponse& message) {
      message.set_resume_token(std::string(1 << 20, 'x'));
      message.set_graph_version(++checks_);
      return absl::StatusOr<bool>(true);
    };
    return absl::StatusOr<Watch<v1::WatchGlobalPosesResponse>>(watch);
  };
  grpc::ClientContext client;
  const auto stream = graph_stub_->WatchGlobalPoses(&client, {});
  int before = -1;
  while (before != checks_ || checks_ == 0) {  // until what gRPC takes ahead is full
    before = checks_;
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  }
  EXPECT_LE(checks_, 40);
  v1::WatchGlobalPosesResponse message;
  for (int i = 1; i <= 60; ++i) {
    ASSERT_TRUE(stream->Read(&message));
    EXPECT_EQ(message.graph_version(), i);
  }
  client.TryCancel();
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
