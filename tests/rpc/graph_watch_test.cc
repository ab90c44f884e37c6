// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "tests/rpc/graph_fixture.h"

namespace enfilade::testing {
namespace {

v1::WatchGlobalPosesRequest WatchRequest() {
  v1::WatchGlobalPosesRequest request;
  request.set_parent("sites/s");
  request.set_rate_hz(20.0);
  return request;
}

TEST_F(GraphTest, WatchersHearWhatChangesAndResumeWhereTheyWere) {
  AwaitSolution();
  Report("b", {1, 0, 0}, 1'000'000'000);
  const auto stub = v1::GraphService::NewStub(connection_->channel());
  v1::WatchGlobalPosesRequest request = WatchRequest();
  std::string token;
  {
    grpc::ClientContext context;
    const auto stream = stub->WatchGlobalPoses(&context, request);
    v1::WatchGlobalPosesResponse message;
    ASSERT_TRUE(stream->Read(&message));
    ASSERT_EQ(message.global_poses_size(), 1);
    EXPECT_EQ(message.global_poses(0).robot(), "sites/s/robots/r");
    EXPECT_NEAR(message.global_poses(0).pose_world_robot().pose().x(), 6.0, 1e-6);
    Report("c", {2, 0, 0}, 2'000'000'000);
    ASSERT_TRUE(stream->Read(&message));
    ASSERT_EQ(message.global_poses_size(), 1);
    EXPECT_NEAR(message.global_poses(0).pose_world_robot().pose().x(), 12.0, 1e-6);
    token = message.resume_token();
    context.TryCancel();
  }
  request.set_resume_token(token);
  grpc::ClientContext context;
  const auto stream = stub->WatchGlobalPoses(&context, request);
  v1::WatchGlobalPosesResponse message;
  ASSERT_TRUE(stream->Read(&message));
  EXPECT_EQ(message.global_poses_size(), 0);
  Report("c", {3, 0, 0}, 3'000'000'000);
  ASSERT_TRUE(stream->Read(&message));
  EXPECT_NEAR(message.global_poses(0).pose_world_robot().pose().x(), 13.0, 1e-6);
  // The server ends streams before it ends itself.
  const auto begin = std::chrono::steady_clock::now();
  server_->Shutdown();
  while (stream->Read(&message)) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60));
}

// A peer's server erased from its list of watchers while it went through it.
TEST_F(GraphTest, WatchersComeAndGoWhilePosesAreReported) {
  AwaitSolution();
  Report("b", {1, 0, 0}, 1'000'000'000);
  const auto stub = v1::GraphService::NewStub(connection_->channel());
  std::atomic<bool> done{false};
  std::thread robot([this, &done] {
    for (std::int64_t i = 2; !done; ++i) Report("b", {1.0 + 0.001 * static_cast<double>(i), 0, 0}, i * 1'000'000'000);
  });
  std::atomic<int> next{0};
  std::vector<std::thread> watchers;
  for (int t = 0; t < 4; ++t) {
    watchers.emplace_back([&stub, &next] {
      for (int i = next++; i < 120; i = next++) {
        grpc::ClientContext context;
        const auto stream = stub->WatchGlobalPoses(&context, WatchRequest());
        v1::WatchGlobalPosesResponse message;
        for (int read = 0; read < i % 3; ++read) {  // some are gone before the first message
          EXPECT_TRUE(stream->Read(&message));
          EXPECT_EQ(message.global_poses_size(), 1);
        }
        context.TryCancel();
      }
    });
  }
  for (std::thread& watcher : watchers) watcher.join();
  done = true;
  robot.join();
  grpc::ClientContext context;
  const auto stream = stub->WatchGlobalPoses(&context, WatchRequest());
  v1::WatchGlobalPosesResponse message;
  ASSERT_TRUE(stream->Read(&message));
  EXPECT_EQ(message.global_poses_size(), 1);
  context.TryCancel();
}

}  // namespace
}  // namespace enfilade::testing
