// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <chrono>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "tests/rpc/graph_fixture.h"
#include "tests/support/eventually.h"
#include "tests/support/server_process.h"

namespace enfilade::testing {
namespace {

using ::testing::ElementsAre;

using Stub = v1::GraphService::Stub;

TEST_F(GraphTest, ChangesOfOthersAreHeardOf) {
  ASSERT_OK(Call(&Stub::GetGlobalPose, At("far", {})));
  Join("mf", "m", "far", {0, 7, 0});  // past this server, as another one would
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (std::chrono::steady_clock::now() < until) {
    ASSERT_OK_AND_ASSIGN(const v1::GetGlobalPoseResponse response, Call(&Stub::GetGlobalPose, At("far", {})));
    if (!response.global_pose().has_pose_world_robot()) continue;
    EXPECT_NEAR(response.global_pose().pose_world_robot().pose().y(), 7.0, 1e-9);
    return;
  }
  FAIL() << "the new link point was not heard of";
}

TEST_F(GraphTest, TheGraphOfADeletedSiteIsGone) {
  ASSERT_OK(Call(&Stub::GetGlobalPose, At("b", {})));
  v1::DeleteSiteRequest request;
  request.set_name("sites/s");
  request.set_force(true);
  ASSERT_OK(Call(&v1::SiteService::Stub::DeleteSite, request));
  EXPECT_TRUE(Eventually([&] { return absl::IsNotFound(Call(&Stub::GetGlobalPose, At("b", {})).status()); }));
}

TEST_F(GraphTest, OptimisesByItselfAndOnRequestAndListsVersions) {
  const v1::Graph solved = AwaitSolution();
  // A third door closes a loop that does not quite fit.
  Join("mc", "m", "c", {0, 5, 0}, {-10, 5.3, 0});
  const v1::Graph again = AwaitGraph([&](const v1::Graph& graph) {
    return graph.solution_version() > solved.solution_version() && graph.solution_version() == graph.graph_version();
  });
  EXPECT_LT(again.maps(1).pose_world_map().pose().y(), 0.0);

  v1::OptimizeGraphRequest request;
  request.set_site("sites/s");
  ASSERT_OK_AND_ASSIGN(const v1::OptimizeGraphResponse response, Call(&Stub::OptimizeGraph, request));
  EXPECT_EQ(response.graph_version(), again.graph_version() + 1);
  EXPECT_TRUE(response.converged());
  EXPECT_EQ(response.maps(), 3);
  EXPECT_EQ(response.degrees_of_freedom(), 3);
  EXPECT_THAT(response.disconnected_maps(), ElementsAre("sites/s/maps/far"));
  EXPECT_EQ(response.switched_off_size(), 0);

  v1::ListGraphVersionsRequest list;
  list.set_parent("sites/s");
  list.set_page_size(2);
  ASSERT_OK_AND_ASSIGN(v1::ListGraphVersionsResponse page, Call(&Stub::ListGraphVersions, list));
  ASSERT_EQ(page.graph_versions_size(), 2);
  EXPECT_EQ(page.graph_versions(0).graph_version(), response.graph_version());
  EXPECT_EQ(page.graph_versions(0).cause(), v1::GraphVersion::CAUSE_OPTIMIZED);
  EXPECT_NEAR(page.graph_versions(0).chi2_after(), response.chi2_after(), 1e-9);
  std::int64_t last = page.graph_versions(1).graph_version();
  while (!page.next_page_token().empty()) {
    list.set_page_token(page.next_page_token());
    ASSERT_OK_AND_ASSIGN(page, Call(&Stub::ListGraphVersions, list));
    for (const v1::GraphVersion& version : page.graph_versions()) {
      EXPECT_EQ(version.graph_version(), last - 1);
      last = version.graph_version();
    }
  }
  EXPECT_EQ(last, 1);
}

TEST_F(GraphTest, ListsWhereMapsWereAfterEachOptimisation) {
  const v1::Graph solved = AwaitSolution();
  Join("mc", "m", "c", {0, 5, 0}, {-10, 5.3, 0});
  const v1::Graph again = AwaitGraph([&](const v1::Graph& graph) {
    return graph.solution_version() > solved.solution_version() && graph.solution_version() == graph.graph_version();
  });
  v1::ListPlacedMapsRequest list;
  list.set_parent("sites/s");
  list.set_page_size(2);
  for (const v1::Graph& graph : {solved, again}) {
    list.set_graph_version(graph.solution_version());
    std::map<std::string, double> listed, wanted;
    for (const v1::GraphMap& map : graph.maps()) {
      if (map.has_pose_world_map()) wanted[map.map()] = map.pose_world_map().pose().y();
    }
    list.clear_page_token();
    do {
      ASSERT_OK_AND_ASSIGN(const auto page, Call(&Stub::ListPlacedMaps, list));
      for (const v1::PlacedMap& map : page.placed_maps()) {
        EXPECT_TRUE(listed.emplace(map.map(), map.pose_world_map().pose().y()).second);
      }
      list.set_page_token(page.next_page_token());
    } while (!list.page_token().empty());
    EXPECT_EQ(listed.size(), 3U);
    for (const auto& [map, y] : wanted) EXPECT_NEAR(listed[map], y, 1e-9) << map;
  }
  list.set_graph_version(1);
  EXPECT_CODE(Call(&Stub::ListPlacedMaps, list), absl::StatusCode::kNotFound);
  list.set_parent("sites/none");
  EXPECT_CODE(Call(&Stub::ListPlacedMaps, list), absl::StatusCode::kNotFound);
}

TEST_F(GraphTest, AFalseClosureIsSwitchedOffAndASuspendedOneLeftOut) {
  AwaitSolution();
  Join("mc", "m", "c", {0, 5, 0}, {-10, 5, 0});
  storage::StoredLinkPoint wrong = Join("wrong", "m", "c", {0, -5, 0}, {20, 5, 1});
  const v1::Graph graph = AwaitGraph(
      [](const v1::Graph& g) { return g.solution_version() == g.graph_version() && g.link_points_size() == 4; });
  ASSERT_EQ(graph.link_points(3).link_point(), "sites/s/linkPoints/wrong");
  EXPECT_FALSE(graph.link_points(3).joins());
  EXPECT_NEAR(graph.maps(1).pose_world_map().pose().x(), 10.0, 1e-3);
  ASSERT_OK_AND_ASSIGN(wrong, link_points_.Get(Soon(), site_, LinkPointId("wrong")));
  EXPECT_EQ(wrong.point.use, graph::LinkPointUse::kSwitchedOff);
  ASSERT_OK(link_points_.SetSuspended(Soon(), site_, LinkPointId("wrong"), 0, true));
  AwaitGraph([&graph](const v1::Graph& g) { return g.graph_version() > graph.graph_version(); });
  v1::OptimizeGraphRequest request;
  request.set_site("sites/s");
  ASSERT_OK_AND_ASSIGN(const v1::OptimizeGraphResponse response, Call(&Stub::OptimizeGraph, request));
  EXPECT_EQ(response.switched_off_size(), 0);
}

// Readers never see a version older than they have seen, nor half of one, whatever editors and the optimisation do.
TEST_F(GraphTest, ReadersGetWholeVersionsWhileEditorsAndOptimisationsChangeThem) {
  std::atomic<bool> done{false};
  std::vector<std::thread> threads;
  for (int editor = 0; editor < 2; ++editor) {
    threads.emplace_back([this, editor] {
      const LinkPointId id(editor == 0 ? "mb" : "bc");
      for (int i = 0; i < 40; ++i) {
        // Each edits its own: placing a link point anew is no edit that the other had to know of.
        auto door = link_points_.Get(Soon(), site_, id);
        ASSERT_OK(door);
        door->point.tag = std::to_string(i);
        door->point.anchors[0].T_map_place.x = 5.0 + 0.01 * i;
        const auto updated = link_points_.Update(Soon(), *door);
        ASSERT_OK(updated);
      }
    });
  }
  std::atomic<int> answers{0};
  for (int reader = 0; reader < 3; ++reader) {
    threads.emplace_back([this, &done, &answers] {
      std::int64_t version = 0;
      while (!done) {
        const auto response = Call(&Stub::GetGlobalPose, At("c", {}));
        ASSERT_OK(response);
        const v1::GlobalPose& pose = response->global_pose();
        ASSERT_GE(pose.graph_version(), version);
        version = pose.graph_version();
        ASSERT_TRUE(pose.has_pose_world_robot());
        ASSERT_GE(pose.pose_world_robot().pose().x(), 10.0 - 1e-6);
        ASSERT_LE(pose.pose_world_robot().pose().x(), 10.8);
        ++answers;
      }
    });
  }
  threads[0].join();
  threads[1].join();
  done = true;
  for (std::size_t i = 2; i < threads.size(); ++i) threads[i].join();
  EXPECT_GT(answers, 0);
  const v1::Graph graph = AwaitSolution();
  EXPECT_NEAR(graph.maps(1).pose_world_map().pose().x(), 10.78, 1e-6);
}

TEST_F(GraphTest, AGraphThatIsEditedWithoutPauseIsOptimised) {
  for (int i = 0; i < 60; ++i) {
    MakeMapNamed(fmt::format("room{}", i));
    Join(fmt::format("door{}", i), i == 0 ? "m" : fmt::format("room{}", i - 1), fmt::format("room{}", i));
  }
  std::atomic<bool> done{false};
  std::vector<std::thread> editors;
  for (const char* door : {"door10", "door30"}) {
    editors.emplace_back([this, &done, id = LinkPointId(door)] {
      for (int i = 0; !done; ++i) {
        auto present = link_points_.Get(Soon(), site_, id);
        ASSERT_OK(present);
        present->point.anchors[0].T_map_place.x = 5.0 + 0.001 * (i % 100);
        const auto updated = link_points_.Update(Soon(), *present);
        ASSERT_TRUE(updated.ok() || absl::IsAborted(updated.status())) << updated.status();
      }
    });
  }
  v1::OptimizeGraphRequest request;
  request.set_site("sites/s");
  for (int i = 0; i < 5; ++i) EXPECT_OK(Call(&Stub::OptimizeGraph, request));
  const v1::Graph before = GetGraph();
  AwaitGraph([&](const v1::Graph& graph) { return graph.solution_version() > before.solution_version() + 10; });
  done = true;
  for (std::thread& editor : editors) editor.join();
}

TEST_F(GraphTest, HealthAnswersWhileGraphsAreOptimised) {
  std::atomic<int> running{4};
  std::vector<std::thread> clients;
  for (int client = 0; client < 4; ++client) {
    clients.emplace_back([this, &running] {
      v1::OptimizeGraphRequest request;
      request.set_site("sites/s");
      for (int i = 0; i < 10; ++i) {
        const auto response = Call(&Stub::OptimizeGraph, request);
        EXPECT_TRUE(response.ok() || absl::IsAborted(response.status())) << response.status();
      }
      --running;
    });
  }
  while (running > 0) EXPECT_EQ(HealthOf(*connection_), Health::kServing);
  for (std::thread& client : clients) client.join();
}

TEST_F(GraphTest, ARobotsGlobalPoseIsThatOfItsLastReport) {
  v1::GetGlobalPoseRequest request;
  request.set_robot("sites/s/robots/r");
  EXPECT_CODE(Call(&Stub::GetGlobalPose, request), absl::StatusCode::kNotFound);
  Report("b", {1, 0, 0}, 1'500'000'000);
  ASSERT_OK_AND_ASSIGN(const v1::GetGlobalPoseResponse response, Call(&Stub::GetGlobalPose, request));
  EXPECT_NEAR(response.global_pose().pose_world_robot().pose().x(), 6.0, 1e-6);
  EXPECT_EQ(response.global_pose().map_pose().map(), "sites/s/maps/b");
  EXPECT_EQ(response.global_pose().report_time().nanos(), 500'000'000);
}
}  // namespace
}  // namespace enfilade::testing
