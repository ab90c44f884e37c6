// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <thread>

#include "fmt/format.h"
#include "storage/postgres/driver/transaction.h"
#include "tests/rpc/graph_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;

// Two servers over one database, and one client that calls both.
class ReplicasTest : public GraphTest {
 protected:
  void SetUp() override {
    GraphTest::SetUp();
    StartSecond(2.0);
  }

  void StartSecond(double version_wait_s) {
    server::ServerOptions options = Options();
    options.graph.version_wait_s = version_wait_s;
    options.database.url = database_.url();
    options.listen.address = "unix:" + (directory_.path() / "second").string();
    options.transfers.cache_directory = (directory_.path() / "cache").string();
    second_.reset();
    auto server = server::Server::Start(options, slam::SlamOptions());
    ASSERT_OK(server);
    second_ = *std::move(server);
    to_second_ = std::make_unique<client::Connection>(connection_->To(second_->address()));
    ASSERT_TRUE(to_second_->channel()->WaitForConnected(std::chrono::system_clock::now() + std::chrono::seconds(60)));
  }

  // On the first server.
  void CreateMap(const std::string& id) {
    v1::CreateMapRequest request;
    request.set_parent("sites/s");
    request.set_map_id(id);
    request.mutable_map()->set_display_name(id);
    ASSERT_OK(Call(&v1::MapService::Stub::CreateMap, request));
  }
  absl::StatusOr<v1::GetGlobalPoseResponse> PoseIn(const client::Connection& connection, const std::string& map) const {
    return connection.Call(&v1::GraphService::Stub::GetGlobalPose, At(map, {}));
  }

  std::unique_ptr<server::Server> second_;
  std::unique_ptr<client::Connection> to_second_;
};

TEST_F(ReplicasTest, WhatAClientWritesOnOneServerItReadsOnAnother) {
  // The same without what our clients send: how often the other server does not know yet. Not asserted: it may be fast.
  const client::Connection forgetful(second_->address(), std::chrono::seconds(60));
  int not_found = 0, old = 0, forgetful_not_found = 0;
  v1::GetGraphRequest graph;
  graph.set_site("sites/s");
  for (int i = 0; i < 200; ++i) {
    const std::string map = fmt::format("room-{}", i);
    CreateMap(map);
    const absl::StatusOr<std::int64_t> version = graph_store_.GetVersion(Soon(), site_);
    ASSERT_OK(version);
    if (i % 2 == 0) forgetful_not_found += absl::IsNotFound(PoseIn(forgetful, map).status()) ? 1 : 0;
    const auto pose = PoseIn(*to_second_, map);
    if (absl::IsNotFound(pose.status())) {
      ++not_found;
      continue;
    }
    ASSERT_OK(pose);
    const auto read = to_second_->Call(&v1::GraphService::Stub::GetGraph, graph);
    ASSERT_OK(read);
    // Later versions are an optimisation's.
    if (read->graph().graph_version() < pose->global_pose().graph_version()) ++old;
    if (read->graph().maps_size() != 5 + i) ++old;
  }
  EXPECT_EQ(not_found, 0);
  EXPECT_EQ(old, 0);
  RecordProperty("not_found_without_versions", forgetful_not_found);
  fmt::print("without versions: {} of 100 NOT_FOUND\n", forgetful_not_found);
}

TEST_F(ReplicasTest, AServerThatCannotReadTheVersionSaysSoAndGivesNoOlderAnswer) {
  constexpr storage::postgres::Statement kLock{"locking",
                                               "LOCK TABLE enfilade.graph_removals IN ACCESS EXCLUSIVE MODE"};
  StartSecond(0.3);
  ASSERT_OK(PoseIn(*to_second_, "c"));  // its graph is cached
  {
    auto lock = storage::postgres::Transaction::Begin(*pool_, Soon());
    ASSERT_OK(lock);
    ASSERT_OK(lock->Execute(kLock, storage::postgres::Params()));
    CreateMap("attic");
    for (const char* map : {"attic", "c"}) {
      EXPECT_STATUS(PoseIn(*to_second_, map), absl::StatusCode::kUnavailable, HasSubstr("call again"));
    }
  }
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  absl::Status read = PoseIn(*to_second_, "attic").status();
  while (absl::IsUnavailable(read) && std::chrono::steady_clock::now() < until) {
    read = PoseIn(*to_second_, "attic").status();
  }
  EXPECT_OK(read);
}

TEST_F(ReplicasTest, AVersionThatDoesNotComeAndOneThatIsNoneAreRefused) {
  StartSecond(0.1);
  const auto stub = v1::GraphService::NewStub(to_second_->channel());
  const auto ask = [&](const std::string& minimum) {
    grpc::ClientContext context;
    context.AddMetadata("enfilade-min-graph-version", minimum);
    v1::GetGlobalPoseResponse response;
    return client::FromGrpcStatus(stub->GetGlobalPose(&context, At("c", {}), &response));
  };
  EXPECT_OK(ask("sites/s=1"));
  EXPECT_OK(ask("sites/other=1000000"));
  EXPECT_STATUS(ask("sites/s=1000000"), absl::StatusCode::kUnavailable, HasSubstr("version 1000000"));
  for (const char* wrong : {"sites/s", "sites/s=x", "7", "sites/s=-1"}) {
    EXPECT_STATUS(ask(wrong), absl::StatusCode::kInvalidArgument, HasSubstr("enfilade-min-graph-version")) << wrong;
  }
}

}  // namespace
}  // namespace enfilade::testing
