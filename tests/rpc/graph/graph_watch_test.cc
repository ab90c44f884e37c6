// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "storage/postgres/driver/transaction.h"
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

// However many watch a site: whether its poses are read or not, other calls have their threads.
TEST_F(GraphTest, WatchersOfASiteShareOneLookAndLeaveOtherCallsTheirThreads) {
  constexpr storage::postgres::Statement kLock{"locking", "LOCK TABLE enfilade.robot_poses IN ACCESS EXCLUSIVE MODE"};
  constexpr int kWatchers = 30;  // more than the executor has threads
  const auto count_held_up = [this] {
    return std::stoi(database_.SqlValue(
        "SELECT count(*) FROM pg_locks WHERE NOT granted AND relation = 'enfilade.robot_poses'::regclass"));
  };
  AwaitSolution();
  Report("b", {1, 0, 0}, 1'000'000'000);
  auto lock = storage::postgres::Transaction::Begin(*pool_, Soon());
  ASSERT_OK(lock);
  ASSERT_OK(lock->Execute(kLock, storage::postgres::Params()));
  const auto stub = v1::GraphService::NewStub(connection_->channel());
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::WatchGlobalPosesResponse>>> streams;
  for (int i = 0; i < kWatchers; ++i) {
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    streams.push_back(stub->WatchGlobalPoses(contexts.back().get(), WatchRequest()));
  }
  while (count_held_up() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const client::Connection quick(server_->address(), std::chrono::seconds(10));
  v1::GetSiteRequest request;
  request.set_name("sites/s");
  for (int i = 0; i < 50; ++i) ASSERT_OK(quick.Call(&v1::SiteService::Stub::GetSite, request));
  EXPECT_EQ(count_held_up(), 1) << "one look for all";
  lock = absl::CancelledError("no longer locked");
  for (int i = 0; i < kWatchers; ++i) {
    v1::WatchGlobalPosesResponse message;
    EXPECT_TRUE(streams[static_cast<std::size_t>(i)]->Read(&message));
    EXPECT_EQ(message.global_poses_size(), 1);
    contexts[static_cast<std::size_t>(i)]->TryCancel();
  }
}

TEST_F(GraphTest, TooManyWatchersAreToldToTryAgain) {
  server::ServerOptions options = Options();
  options.watches.max_per_site = 2;
  Restart(options);
  const auto stub = v1::GraphService::NewStub(connection_->channel());
  v1::WatchGlobalPosesResponse message;
  const auto open = [&](grpc::ClientContext& context) { return stub->WatchGlobalPoses(&context, WatchRequest()); };
  grpc::ClientContext contexts[3];
  const auto first = open(contexts[0]);
  const auto second = open(contexts[1]);
  ASSERT_TRUE(first->Read(&message));
  ASSERT_TRUE(second->Read(&message));
  const auto refused = open(contexts[2]);
  EXPECT_FALSE(refused->Read(&message));
  const grpc::Status status = refused->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(status.error_message(), ::testing::HasSubstr("try again in a minute"));
  contexts[0].TryCancel();
  first->Finish();
  bool admitted = false;
  for (int i = 0; i < 1000 && !admitted; ++i) {
    grpc::ClientContext context;
    admitted = open(context)->Read(&message);
    context.TryCancel();
    if (!admitted) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(admitted);
  contexts[1].TryCancel();
}

}  // namespace
}  // namespace enfilade::testing
