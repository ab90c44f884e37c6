// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/site_graphs.h"

#include <atomic>
#include <latch>
#include <thread>
#include <vector>

#include "core/graph/graph_optimization.h"
#include "tests/unit/server/app/graph/graph_test.h"

namespace enfilade::server {
namespace {

using ::testing::HasSubstr;
using Listening = GraphStoreProbe::Listening;

class SiteGraphsTest : public AppGraphTest {
 protected:
  // Stores a solution of the present graph, as another process does. Returns its version.
  std::int64_t Solve() {
    const auto changes = stores_.graphs.ReadChanges(Soon(), site_, 0);
    EXPECT_OK(changes);
    const auto graph = graph::Apply(graph::GraphSnapshot(), ToSnapshotChanges(*changes));
    EXPECT_OK(graph);
    const auto solution = graph::OptimizeGraph(*graph);
    EXPECT_OK(solution);
    const SiteGraph before(*graph, PlacedLinkPoints().With({}, *graph, *changes));
    const auto version =
        stores_.graphs.Apply(Soon(), site_, changes->version, ToStored(before, graph::WorldPoses(*graph), *solution));
    EXPECT_OK(version);
    return version.value_or(0);
  }
};

TEST_F(SiteGraphsTest, ReadsTheWholeGraphAtItsVersion) {
  Start();
  const auto graph = Get();
  EXPECT_EQ(graph->graph().version(), Version());
  EXPECT_EQ(graph->graph().root(), MapId("a"));
  EXPECT_EQ(graph->solution_version, 0);
  EXPECT_NEAR(WorldXOfC(*graph), 20.0, 1e-9);
  EXPECT_FALSE(graph->georeference.has_value());
}

TEST_F(SiteGraphsTest, ASiteMayHaveNoMapsAndMustExist) {
  Start();
  EXPECT_EQ(Get(other_site_)->graph().version(), 0);
  EXPECT_TRUE(Get(other_site_)->graph().root().empty());
  EXPECT_CODE(graphs_->Get(Soon(), SiteId("nowhere")), absl::StatusCode::kNotFound);
  stores_.database.AddSite(SiteId("nowhere"));
  EXPECT_OK(graphs_->Get(Soon(), SiteId("nowhere"))) << "the absence of a site must not be cached";
}

TEST_F(SiteGraphsTest, AnswersFromMemoryWhileTheStoreNotifies) {
  StartListening();
  const int reads = probe_.reads();
  const auto first = Get();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(Get(), first);
  EXPECT_EQ(graphs_->FindCurrent(site_), first);
  EXPECT_EQ(probe_.reads(), reads);
}

TEST_F(SiteGraphsTest, ANotificationUpdatesTheGraph) {
  StartListening();
  const auto before = Get();
  EXPECT_NEAR(WorldXOfC(*AwaitVersion(MoveDoor(12))), 22.0, 1e-9);
  EXPECT_NEAR(WorldXOfC(*before), 20.0, 1e-9) << "a version that is in use does not change";
}

TEST_F(SiteGraphsTest, SitesWithoutReadersAreReadForTheOptimiser) {
  StartListening();
  changed_.Take();
  ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(other_site_, "x"), ""));
  while (!changed_.Take().contains(other_site_)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

TEST_F(SiteGraphsTest, AnEditIsInEveryLaterAnswerOfTheSameProcess) {
  probe_.set_listening(Listening::kSilent);
  StartListening();
  const std::int64_t before = Get()->graph().version();
  const std::int64_t after = MoveDoor(12);
  EXPECT_EQ(Get()->graph().version(), before) << "not notified: the cached version";
  graphs_->MarkChanged(site_);
  EXPECT_EQ(graphs_->FindCurrent(site_), nullptr) << "must not answer without reading";
  EXPECT_EQ(Get()->graph().version(), after);
  EXPECT_NE(graphs_->FindCurrent(site_), nullptr);
  graphs_->MarkChanged(SiteId("unknown"));  // no-op
}

TEST_F(SiteGraphsTest, AChangeWhoseNotificationWasLostIsFound) {
  probe_.set_listening(Listening::kLossy);
  StartListening();
  const std::int64_t before = Get()->graph().version();
  const std::int64_t after = MoveDoor(12);
  ASSERT_GT(after, before);
  while (Get()->graph().version() < after) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

TEST_F(SiteGraphsTest, WithoutNotificationsEveryAnswerChecksTheStore) {
  probe_.set_listening(Listening::kBroken);
  Start();
  for (int i = 0; i < 5; ++i) {
    const std::int64_t version = MoveDoor(10.0 + i);
    EXPECT_EQ(Get()->graph().version(), version);
    EXPECT_EQ(graphs_->FindCurrent(site_), nullptr);
  }
}

TEST_F(SiteGraphsTest, WhatChangedWhileTheConnectionWasLostIsRead) {
  StartListening();
  const std::int64_t before = Get()->graph().version();
  probe_.set_listening(Listening::kBroken);
  while (graphs_->FindCurrent(site_) != nullptr) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const std::int64_t after = MoveDoor(12);
  probe_.set_listening(Listening::kSilent);  // nothing will notify of that change
  while (true) {
    const auto graph = Get();
    EXPECT_GE(graph->graph().version(), before);
    const auto current = graphs_->FindCurrent(site_);
    if (current == nullptr) continue;
    EXPECT_EQ(current->graph().version(), after);
    return;
  }
}

TEST_F(SiteGraphsTest, ReadersOfTheOldVersionDoNotWaitForTheNewOne) {
  StartListening();
  const auto before = Get();
  std::latch reading(1);
  std::latch go_on(1);
  std::atomic<bool> first{true};
  probe_.set_after_read([&] {
    if (!first.exchange(false)) return;
    reading.count_down();
    go_on.wait();
  });
  const std::int64_t after = MoveDoor(12);
  reading.wait();  // the listening thread is in the middle of it
  EXPECT_EQ(Get(), before);
  EXPECT_EQ(graphs_->FindCurrent(site_), before);
  go_on.count_down();
  AwaitVersion(after);
}

TEST_F(SiteGraphsTest, ReadersThatNeedAChangeShareOneRead) {
  probe_.set_listening(Listening::kSilent);
  StartListening();
  const std::int64_t after = MoveDoor(12);
  graphs_->MarkChanged(site_);
  const int before = probe_.reads();
  std::latch reading(1);
  std::latch go_on(1);
  probe_.set_after_read([&] {
    reading.count_down();
    go_on.wait();
  });
  std::vector<std::thread> readers;
  for (int i = 0; i < 6; ++i) {
    readers.emplace_back([&] { EXPECT_EQ(Get()->graph().version(), after); });
  }
  reading.wait();
  go_on.count_down();
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(probe_.reads(), before + 1);
}

TEST_F(SiteGraphsTest, AFailedReadIsReportedAndTriedAgain) {
  probe_.set_listening(Listening::kSilent);
  StartListening();
  const std::int64_t after = MoveDoor(12);
  graphs_->MarkChanged(site_);
  stores_.database.FailCalls(absl::UnavailableError("gone"));
  EXPECT_CODE(graphs_->Get(Soon(), site_), absl::StatusCode::kUnavailable);
  stores_.database.FailCalls(absl::OkStatus());
  EXPECT_EQ(Get()->graph().version(), after);
}

TEST_F(SiteGraphsTest, KeepsTheLastFewVersions) {
  probe_.set_listening(Listening::kBroken);
  Start();
  std::vector<std::shared_ptr<const SiteGraph>> versions;
  for (int i = 0; i < 10; ++i) {
    MoveDoor(11.0 + i);
    versions.push_back(Get());
  }
  const std::int64_t current = versions.back()->graph().version();
  ASSERT_OK_AND_ASSIGN(const auto latest, graphs_->GetVersion(Soon(), site_, 0));
  EXPECT_EQ(latest, versions.back());
  for (int back = 0; back < 8; ++back) {
    ASSERT_OK_AND_ASSIGN(const auto kept, graphs_->GetVersion(Soon(), site_, current - back));
    EXPECT_EQ(kept, versions[versions.size() - 1 - static_cast<std::size_t>(back)]);
  }
  EXPECT_STATUS(graphs_->GetVersion(Soon(), site_, current - 8), absl::StatusCode::kNotFound,
                HasSubstr("not one of the last 8"));
  EXPECT_CODE(graphs_->GetVersion(Soon(), site_, current + 1), absl::StatusCode::kNotFound);
  EXPECT_CODE(graphs_->GetVersion(Soon(), SiteId("nowhere"), 1), absl::StatusCode::kNotFound);
}

TEST_F(SiteGraphsTest, AddsASiteToTheChangedOnesWithEveryNewVersionOnly) {
  probe_.set_listening(Listening::kBroken);
  Start();
  Get();
  EXPECT_EQ(changed_.Take(), std::set<SiteId>{site_});
  Get();
  EXPECT_TRUE(changed_.Take().empty()) << "nothing has changed";
  MoveDoor(12);
  Get();
  EXPECT_EQ(changed_.Take(), std::set<SiteId>{site_});
}

TEST_F(SiteGraphsTest, ASolutionIsPartOfItsVersionAndOfThoseAfterIt) {
  probe_.set_listening(Listening::kBroken);
  Start();
  const std::int64_t solved = Solve();
  EXPECT_EQ(Get()->graph().version(), solved);
  EXPECT_EQ(Get()->solution_version, solved);
  ASSERT_NE(Get()->graph().solution(), nullptr);
  MoveDoor(12);
  EXPECT_GT(Get()->graph().version(), solved);
  EXPECT_EQ(Get()->solution_version, solved);
  const std::int64_t again = Solve();
  EXPECT_EQ(Get()->solution_version, again);
  EXPECT_NEAR(WorldXOfC(*Get()), 22.0, 1e-6);
}

TEST_F(SiteGraphsTest, ASolutionForAnotherRootDoesNotCount) {
  probe_.set_listening(Listening::kBroken);
  Start();
  Solve();
  ASSERT_GT(Get()->solution_version, 0);
  ASSERT_OK(stores_.maps.Delete(Soon(), site_, MapId("a"), 0, /*force=*/true));
  EXPECT_EQ(Get()->graph().root(), MapId("b"));
  EXPECT_EQ(Get()->solution_version, 0);
  EXPECT_NEAR(WorldXOfC(*Get()), 10.0, 1e-9) << "by the link point, in the new root's frame";
}

// The store reads changes and the last optimisation separately: one that is committed in between belongs to a later
// version than the changes.
TEST_F(SiteGraphsTest, AnOptimisationBetweenTheTwoReadsDoesNotMixVersions) {
  probe_.set_listening(Listening::kBroken);
  Start();
  Get();
  MoveDoor(12);
  std::int64_t solved = 0;
  probe_.set_after_read([&] {
    if (solved != 0) return;
    MoveDoor(14);
    solved = Solve();
  });
  const auto graph = Get();
  ASSERT_GT(solved, 0);
  EXPECT_EQ(graph->graph().version(), solved);
  EXPECT_EQ(graph->solution_version, solved);
  EXPECT_EQ(graph->graph().FindLinkPoint(LinkPointId("bc"))->anchors[0].T_map_place.x, 14.0);
}

TEST_F(SiteGraphsTest, ControlPointsThatFitGiveAGeoreference) {
  probe_.set_listening(Listening::kBroken);
  Start();
  // 0.001 degrees of latitude are about 111 m; map c's origin is 20 m along x from map a's.
  const std::vector<storage::ControlPoint> fitting = {{MapId("a"), {0, 0}, 48.0, 11.0},
                                                      {MapId("c"), {91.2, 0}, 48.001, 11.0}};
  ASSERT_OK(stores_.graphs.SetControlPoints(Soon(), site_, fitting));
  EXPECT_EQ(Get()->control_points.size(), 2U);
  EXPECT_TRUE(Get()->georeference.has_value());
  std::vector<storage::ControlPoint> mismatched = fitting;
  mismatched[1].position.x() = 500.0;
  ASSERT_OK(stores_.graphs.SetControlPoints(Soon(), site_, mismatched));
  EXPECT_EQ(Get()->control_points.size(), 2U);
  EXPECT_FALSE(Get()->georeference.has_value());
}

// An editor moves two doors, one after the other, by the same amount: what a reader sees must be a version that
// existed.
TEST_F(SiteGraphsTest, ConcurrentReadersGetWholeVersionsInOrder) {
  StartListening();
  std::atomic<bool> done{false};
  std::vector<std::thread> readers;
  std::atomic<int> versions_seen{0};
  for (int i = 0; i < 3; ++i) {
    readers.emplace_back([&] {
      std::int64_t last = 0;
      while (!done) {
        const auto graph = Get();
        ASSERT_GE(graph->graph().version(), last);
        if (graph->graph().version() > last) ++versions_seen;
        last = graph->graph().version();
        const double x_ab = graph->graph().FindLinkPoint(LinkPointId("ab"))->anchors[0].T_map_place.x;
        const double x_bc = graph->graph().FindLinkPoint(LinkPointId("bc"))->anchors[0].T_map_place.x;
        ASSERT_TRUE(x_ab == x_bc || x_ab == x_bc + 1.0) << x_ab << " " << x_bc;
        ASSERT_NEAR(WorldXOfC(*graph), x_ab + x_bc, 1e-9);
      }
    });
  }
  for (int i = 1; i <= 100; ++i) {
    for (const char* id : {"ab", "bc"}) {
      auto door = stores_.link_points.Get(Soon(), site_, LinkPointId(id));
      ASSERT_OK(door);
      door->point.anchors[0].T_map_place.x = 10.0 + i;
      ASSERT_OK(stores_.link_points.Update(Soon(), *door));
      if (i % 3 == 0) graphs_->MarkChanged(site_);
    }
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  AwaitVersion(Version());
  done = true;
  for (std::thread& reader : readers) reader.join();
  EXPECT_GT(versions_seen, 3);
}

TEST_F(SiteGraphsTest, StopEndsStreamsAndKeepsAnswering) {
  StartListening();
  EXPECT_FALSE(graphs_->stopping());
  graphs_->Stop();
  EXPECT_TRUE(graphs_->stopping());
  EXPECT_OK(graphs_->Get(Soon(), site_));
}

}  // namespace
}  // namespace enfilade::server
