// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <thread>
#include <vector>

#include "storage/postgres/driver/transaction.h"
#include "tests/rpc/site_watch_fixture.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

TEST_F(SiteWatchTest, AnEmptySiteAnswersAtOnce) {
  v1::CreateSiteRequest create;
  create.set_site_id("empty");
  create.mutable_site()->set_display_name("Empty");
  ASSERT_OK(Call(&v1::SiteService::Stub::CreateSite, create));
  v1::WatchSiteRequest request = Request();
  request.set_parent("sites/empty");
  SiteViewer viewer(*connection_, request);
  ASSERT_TRUE(viewer.Read());
  EXPECT_TRUE(viewer.last().start().reset());
  EXPECT_FALSE(viewer.last().start().server_version().empty());
  EXPECT_FALSE(viewer.last().resume_token().empty());
  EXPECT_TRUE(viewer.last().has_health());
  EXPECT_TRUE(viewer.last().has_graph());
  EXPECT_EQ(viewer.items, 0);
}

TEST_F(SiteWatchTest, FirstTellsWhatIsThere) {
  AwaitSolution();
  Report("b", {1, 0, 0}, 1'000'000'000);
  AddRevision("c");
  const std::string session = CreateSession(/*mapped=*/false);
  SiteViewer viewer = Watch();
  ASSERT_TRUE(viewer.Read());
  EXPECT_EQ(viewer.maps.size(), 4U);
  EXPECT_NEAR(viewer.maps["sites/s/maps/c"].pose_world_map().pose().x(), 10.0, 1e-6);
  EXPECT_FALSE(viewer.maps["sites/s/maps/far"].has_pose_world_map());
  EXPECT_EQ(viewer.last().health().disconnected_maps(), 1);
  EXPECT_EQ(viewer.last().graph().root_map(), "sites/s/maps/m");
  EXPECT_EQ(viewer.last().graph().solution_version(), viewer.last().graph().graph_version());
  ASSERT_EQ(viewer.link_points.size(), 2U);
  EXPECT_TRUE(viewer.link_points["sites/s/linkPoints/bc"].joins());
  EXPECT_EQ(viewer.link_points["sites/s/linkPoints/bc"].kind(), v1::LinkPoint::KIND_DOOR);
  EXPECT_NEAR(viewer.link_points["sites/s/linkPoints/bc"].pose_world_place().pose().x(), 10.0, 1e-6);
  EXPECT_EQ(viewer.rasters["sites/s/maps/c"].revision(), "sites/s/maps/c/revisions/1");
  EXPECT_EQ(viewer.sessions[session].state(), v1::Session::STATE_RECORDING);
  const v1::RobotState& robot = viewer.robots["sites/s/robots/r"];
  EXPECT_EQ(robot.map(), "sites/s/maps/b");
  EXPECT_NEAR(robot.pose_world_robot().x(), 6.0, 1e-6);
  EXPECT_EQ(robot.covariance_size(), 4);
  EXPECT_FALSE(robot.has_global_pose());
}

TEST_F(SiteWatchTest, AnEditComesAsWhatHasChangedOnly) {
  AwaitSolution();
  SiteViewer viewer = Watch();
  ASSERT_TRUE(viewer.Read());
  const int before = viewer.items;
  MakeMapNamed("d");
  viewer.ReadUntil([&] { return viewer.maps.contains("sites/s/maps/d"); });
  EXPECT_EQ(viewer.items - before, 1);
  Join("cd", "c", "d");
  viewer.ReadUntil([&] {
    return viewer.link_points.contains("sites/s/linkPoints/cd") && viewer.maps["sites/s/maps/d"].has_pose_world_map();
  });
  EXPECT_FALSE(viewer.last().has_start());
  v1::DeleteMapRequest remove;
  remove.set_name("sites/s/maps/far");
  ASSERT_OK(Call(&v1::MapService::Stub::DeleteMap, remove));
  viewer.ReadUntil([&] { return !viewer.maps.contains("sites/s/maps/far"); });
  EXPECT_THAT(viewer.last().graph().removed_maps(), ElementsAre("sites/s/maps/far"));
}

// The optimisation shares a contradiction out: the maps between the contradicting link points move, and robots with
// them.
TEST_F(SiteWatchTest, AnOptimizationMovesMapsAndTheRobotsInThem) {
  AwaitSolution();
  Report("b", {1, 0, 0}, 1'000'000'000);
  SiteViewer viewer = Watch();
  ASSERT_TRUE(viewer.Read());
  ASSERT_NEAR(viewer.robots["sites/s/robots/r"].pose_world_robot().x(), 6.0, 1e-6);
  Join("mc", "m", "c", {10.1, 0, 0}, {});
  viewer.ReadUntil([&] { return std::abs(viewer.maps["sites/s/maps/b"].pose_world_map().pose().x() - 5.0) > 0.01; });
  viewer.ReadUntil([&] { return std::abs(viewer.robots["sites/s/robots/r"].pose_world_robot().x() - 6.0) > 0.01; });
  EXPECT_NEAR(viewer.robots["sites/s/robots/r"].pose_world_robot().x(),
              viewer.maps["sites/s/maps/b"].pose_world_map().pose().x() + 1.0, 1e-6);
  EXPECT_EQ(viewer.robots["sites/s/robots/r"].pose_map_robot().x(), 1.0);
}

TEST_F(SiteWatchTest, SessionsComeGrowEndAndGo) {
  SiteViewer viewer = Watch();
  ASSERT_TRUE(viewer.Read());
  const std::string session = CreateSession(/*mapped=*/false);
  viewer.ReadUntil([&] { return viewer.sessions.contains(session); });
  EXPECT_EQ(viewer.sessions[session].state(), v1::Session::STATE_RECORDING);
  EXPECT_EQ(viewer.sessions[session].robot(), "sites/s/robots/r");
  TestStream stream(*connection_, session);
  ASSERT_TRUE(stream.SendBatch(ScanRecords(1, 5)));
  ASSERT_TRUE(stream.AwaitAcknowledged(5));
  viewer.ReadUntil([&] { return viewer.sessions[session].acknowledged_sequence() == 5; });
  ASSERT_OK(stream.Finish());
  ASSERT_OK(FinishSession(session, 5));
  viewer.ReadUntil([&] { return viewer.sessions[session].state() == v1::Session::STATE_MAPPED; });
  v1::DeleteSessionRequest remove;
  remove.set_name(session);
  ASSERT_OK(Call(&v1::SessionService::Stub::DeleteSession, remove));
  viewer.ReadUntil([&] { return !viewer.sessions.contains(session); });
}

TEST_F(SiteWatchTest, RevisionsAndRemovedRobotsAreTold) {
  Report("b", {1, 0, 0}, 1'000'000'000);
  SiteViewer viewer = Watch();
  ASSERT_TRUE(viewer.Read());
  ASSERT_TRUE(viewer.robots.contains("sites/s/robots/r"));
  AddRevision("b");
  viewer.ReadUntil([&] { return viewer.rasters.contains("sites/s/maps/b"); });
  AddRevision("b");
  viewer.ReadUntil([&] { return viewer.rasters["sites/s/maps/b"].revision() == "sites/s/maps/b/revisions/2"; });
  v1::DeleteRobotRequest remove;
  remove.set_name("sites/s/robots/r");
  ASSERT_OK(Call(&v1::RobotService::Stub::DeleteRobot, remove));
  viewer.ReadUntil([&] { return viewer.robots.empty(); });
}

TEST_F(SiteWatchTest, ResumesWithoutLossAndWithoutTellingAgain) {
  AwaitSolution();
  Report("b", {1, 0, 0}, 1'000'000'000);
  AddRevision("b");
  const std::string open = CreateSession(/*mapped=*/false);
  std::string token;
  {
    SiteViewer viewer = Watch();
    ASSERT_TRUE(viewer.Read());
    token = viewer.token;
  }
  {
    SiteViewer quiet = Watch(token);
    ASSERT_TRUE(quiet.Read());
    EXPECT_FALSE(quiet.last().start().reset());
    EXPECT_EQ(quiet.items, 0) << quiet.last().ShortDebugString();
  }
  MakeMapNamed("d");
  Join("cd", "c", "d");
  v1::DeleteMapRequest remove_map;
  remove_map.set_name("sites/s/maps/far");
  ASSERT_OK(Call(&v1::MapService::Stub::DeleteMap, remove_map));
  AwaitSolution();
  Report("c", {2, 0, 0}, 2'000'000'000);
  AddRevision("c");
  const std::string brief = CreateSession(/*mapped=*/false);
  ASSERT_OK(FinishSession(brief, 0));
  v1::DeleteSessionRequest remove;
  remove.set_name(open);
  ASSERT_OK(Call(&v1::SessionService::Stub::DeleteSession, remove));
  {
    SiteViewer viewer = Watch(token);
    viewer.ReadUntil([&] { return viewer.rasters.contains("sites/s/maps/c"); });
    EXPECT_FALSE(viewer.was_reset);
    EXPECT_TRUE(viewer.maps["sites/s/maps/d"].has_pose_world_map());
    EXPECT_FALSE(viewer.maps.contains("sites/s/maps/m"));
    EXPECT_FALSE(viewer.link_points.contains("sites/s/linkPoints/mb"));
    EXPECT_THAT(viewer.removed, UnorderedElementsAre("sites/s/maps/far", open));
    EXPECT_EQ(viewer.sessions[brief].state(), v1::Session::STATE_MAPPED);
    EXPECT_EQ(viewer.robots["sites/s/robots/r"].map(), "sites/s/maps/c");
    token = viewer.token;
  }
  // Another process knows nothing of what its clients have seen before.
  Restart(Options());
  SiteViewer after = Watch(token);
  ASSERT_TRUE(after.Read());
  EXPECT_FALSE(after.last().start().reset());
  EXPECT_TRUE(after.maps.empty() && after.robots.empty() && after.rasters.empty()) << after.last().ShortDebugString();
}

TEST_F(SiteWatchTest, WhatCannotBeResumedIsToldFromTheBeginning) {
  AwaitSolution();
  for (const char* token : {"nonsense", "1-2-3-4-5-6-7-8", "9-1-1-1-1-1-1-1", "1-1-1-1-1-1-1-1-1"}) {
    SiteViewer viewer = Watch(token);
    ASSERT_TRUE(viewer.Read()) << token;
    EXPECT_TRUE(viewer.last().start().reset()) << token;
    EXPECT_EQ(viewer.maps.size(), 4U) << token;
  }
}

TEST_F(SiteWatchTest, ALargeSiteComesInPartsThatShareOneToken) {
  for (int i = 0; i < 1100; ++i) MakeMapNamed(fmt::format("room-{}", i));
  AwaitGraph([](const v1::Graph& graph) { return graph.maps_size() == 1104; });
  SiteViewer viewer = Watch();
  ASSERT_TRUE(viewer.Read());
  EXPECT_TRUE(viewer.last().more());
  EXPECT_TRUE(viewer.last().resume_token().empty());
  EXPECT_EQ(SiteViewer::CountItems(viewer.last()), 1000);
  ASSERT_TRUE(viewer.Read());
  EXPECT_FALSE(viewer.last().more());
  EXPECT_FALSE(viewer.last().resume_token().empty());
  EXPECT_EQ(viewer.maps.size(), 1104U);
  EXPECT_EQ(viewer.link_points.size(), 2U);
}

TEST_F(SiteWatchTest, RobotsOfOtherLevelsAreLeftOutAndLeave) {
  AwaitSolution();
  storage::Map upstairs = *maps_.Get(Soon(), site_, MapId("c"));
  upstairs.level = 1;
  ASSERT_OK(maps_.Update(Soon(), upstairs));
  const auto version = graph_store_.GetVersion(Soon(), site_);
  ASSERT_OK(version);
  AwaitGraph([&](const v1::Graph& graph) { return graph.graph_version() >= *version; });
  Report("b", {1, 0, 0}, 1'000'000'000);
  v1::WatchSiteRequest request = Request();
  request.add_levels(0);
  request.set_view(v1::ROBOT_VIEW_FULL);
  SiteViewer viewer(*connection_, request);
  ASSERT_TRUE(viewer.Read());
  EXPECT_EQ(viewer.robots["sites/s/robots/r"].global_pose().hops_size() +
                static_cast<int>(viewer.robots["sites/s/robots/r"].global_pose().solution_version() > 0),
            1);
  Report("c", {1, 0, 0}, 2'000'000'000);
  viewer.ReadUntil([&] { return viewer.robots.empty(); });
  EXPECT_THAT(viewer.last().removed_robots(), ElementsAre("sites/s/robots/r"));
}

TEST_F(SiteWatchTest, AQuietSiteIsHeardOf) {
  AwaitSolution();
  SiteViewer viewer = Watch();
  ASSERT_TRUE(viewer.Read());
  const int before = viewer.items;
  const v1::WatchSiteResponse first = viewer.last();
  ASSERT_TRUE(viewer.Read());
  EXPECT_EQ(viewer.items, before);
  EXPECT_FALSE(viewer.last().has_graph());
  const auto silence = viewer.last().send_time().seconds() - first.send_time().seconds();
  RecordProperty("silence_s", static_cast<int>(silence));
}

TEST_F(SiteWatchTest, WatchersOfASiteShareOneLook) {
  constexpr storage::postgres::Statement kLock{"locking", "LOCK TABLE enfilade.mapping_work IN ACCESS EXCLUSIVE MODE"};
  const auto count_held_up = [this] {
    return std::stoi(database_.SqlValue(
        "SELECT count(*) FROM pg_locks WHERE NOT granted AND relation = 'enfilade.mapping_work'::regclass"));
  };
  server::ServerOptions options = Options();
  options.mapping.workers = 0;
  Restart(options);
  auto lock = storage::postgres::Transaction::Begin(*pool_, Soon());
  ASSERT_OK(lock);
  ASSERT_OK(lock->Execute(kLock, storage::postgres::Params()));
  std::vector<std::unique_ptr<SiteViewer>> viewers;
  for (int i = 0; i < 30; ++i) viewers.push_back(std::make_unique<SiteViewer>(*connection_, Request()));
  while (count_held_up() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(count_held_up(), 1) << "one look for all";
  lock = absl::CancelledError("no longer locked");
  for (const auto& viewer : viewers) {
    ASSERT_TRUE(viewer->Read());
    EXPECT_EQ(viewer->maps.size(), 4U);
  }
}

TEST_F(SiteWatchTest, BothKindsOfWatchesCountAndWrongOnesAreRefused) {
  server::ServerOptions options = Options();
  options.watches.max_per_site = 2;
  Restart(options);
  SiteViewer first = Watch();
  ASSERT_TRUE(first.Read());
  const auto poses = v1::GraphService::NewStub(connection_->channel());
  grpc::ClientContext context;
  v1::WatchGlobalPosesRequest other;
  other.set_parent("sites/s");
  const auto second = poses->WatchGlobalPoses(&context, other);
  v1::WatchGlobalPosesResponse message;
  ASSERT_TRUE(second->Read(&message));
  SiteViewer refused = Watch();
  EXPECT_FALSE(refused.Read());
  EXPECT_EQ(refused.Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  context.TryCancel();

  v1::WatchSiteRequest wrong = Request();
  wrong.set_rate_hz(0.1);
  v1::WatchSiteRequest unknown = Request();
  unknown.set_parent("sites/nowhere");
  for (const auto& [request, code] :
       {std::pair(wrong, grpc::StatusCode::INVALID_ARGUMENT), std::pair(unknown, grpc::StatusCode::NOT_FOUND),
        std::pair(v1::WatchSiteRequest(), grpc::StatusCode::INVALID_ARGUMENT)}) {
    SiteViewer viewer(*connection_, request);
    EXPECT_FALSE(viewer.Read());
    EXPECT_EQ(viewer.Finish().error_code(), code);
  }
}

}  // namespace
}  // namespace enfilade::testing
