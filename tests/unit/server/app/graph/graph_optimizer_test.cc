// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/graph_optimizer.h"

#include <atomic>
#include <thread>

#include "tests/unit/server/app/graph/graph_test.h"

namespace enfilade::server {
namespace {

using Listening = GraphStoreProbe::Listening;

constexpr auto kSiteLeaseTime = std::chrono::hours(1);

// Counts how often a site is about to be solved.
class CountingLeases final : public storage::SiteLeaseStore {
 public:
  explicit CountingLeases(const storage::SiteLeaseStore& leases) : leases_(leases) {}
  int count() const { return count_; }

  absl::StatusOr<std::optional<storage::SiteLease>> Acquire(const storage::CallContext& context, const SiteId& site,
                                                            const std::string& owner,
                                                            std::chrono::milliseconds ttl) const override {
    ++count_;
    return leases_.Acquire(context, site, owner, ttl);
  }
  absl::Status Renew(const storage::CallContext& context, const storage::SiteLease& lease,
                     std::chrono::milliseconds ttl) const override {
    return leases_.Renew(context, lease, ttl);
  }
  absl::Status Release(const storage::CallContext& context, const storage::SiteLease& lease) const override {
    return leases_.Release(context, lease);
  }

 private:
  const storage::SiteLeaseStore& leases_;
  mutable std::atomic<int> count_ = 0;
};

class GraphOptimizerTest : public AppGraphTest {
 protected:
  // Doors that do not fit exactly, so that a solution differs from the chain of link points.
  GraphOptimizerTest() { Join("ac", "a", "c", {20.3, 0, 0}); }

  void StartOptimizer() {
    optimizer_.emplace(probe_, GraphOptimizer::Leases{stores_.solver_leases, stores_.site_leases}, *graphs_, changed_);
  }
  void StartAll() {
    Start();
    StartOptimizer();
  }
  storage::SiteLease HoldLease() {
    auto lease = stores_.site_leases.Acquire(Soon(), site_, "another process", kSiteLeaseTime);
    EXPECT_OK(lease);
    EXPECT_TRUE(lease->has_value());
    return **lease;
  }
  bool IsLeaseFree() {
    const auto lease = stores_.site_leases.Acquire(Soon(), site_, "a test", kSiteLeaseTime);
    if (!lease.ok() || !lease->has_value()) return false;
    EXPECT_OK(stores_.site_leases.Release(Soon(), **lease));
    return true;
  }
  std::int64_t LastSolution(const SiteId& site) { return *stores_.graphs.FindLastOptimization(Soon(), site, 0); }
  std::int64_t AwaitSolution(const SiteId& site, std::int64_t after) {
    while (LastSolution(site) <= after) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return LastSolution(site);
  }

  std::optional<GraphOptimizer> optimizer_;
};

TEST_F(GraphOptimizerTest, StoresASolutionOnRequest) {
  Start();
  StartOptimizer();
  ASSERT_OK_AND_ASSIGN(const OptimizedGraph optimized, optimizer_->Optimize(Soon(), site_));
  EXPECT_EQ(optimized.solution.map_poses.size(), 3U);
  EXPECT_LT(optimized.solution.chi2_after, optimized.solution.chi2_before);
  // 10 + 10 by two doors against 20.3 by one: three residuals share the 0.3 m.
  EXPECT_NEAR(WorldXOfC(*Get()), 20.2, 0.01);
  EXPECT_GE(Get()->solution_version, optimized.version) << "the same process answers with it";
  EXPECT_TRUE(IsLeaseFree());
}

TEST_F(GraphOptimizerTest, ANewRoomWritesTheNewRoomOnly) {
  StartAll();
  ASSERT_OK(optimizer_->Optimize(Soon(), site_));
  AddMap("d");
  Join("cd", "c", "d", {5, 0, 0});
  graphs_->MarkChanged(site_);
  const std::int64_t before = Version();
  ASSERT_OK_AND_ASSIGN(const OptimizedGraph optimized, optimizer_->Optimize(Soon(), site_));
  EXPECT_EQ(optimized.solution.map_poses.size(), 4U);
  ASSERT_OK_AND_ASSIGN(const storage::GraphChanges changes, stores_.graphs.ReadChanges(Soon(), site_, before));
  std::vector<std::string> changed;
  for (const storage::GraphMap& map : changes.maps) changed.push_back(map.id.value());
  for (const storage::StoredLinkPoint& door : changes.link_points) changed.push_back(door.point.id.value());
  EXPECT_THAT(changed, ::testing::IsSubsetOf({"d", "cd"})) << "all others have their poses to within rounding";
  // Readers have the whole solution, by its changes or from the start.
  EXPECT_EQ(Get()->graph().solution()->map_poses.size(), 4U);
  ChangedSites unused;
  SiteGraphs another(probe_, unused);
  ASSERT_OK_AND_ASSIGN(const auto graph, another.Get(Soon(), site_));
  EXPECT_EQ(graph->graph().solution()->map_poses.size(), 4U);
  EXPECT_NEAR(WorldXOfC(*graph), WorldXOfC(*Get()), 1e-12);
}

TEST_F(GraphOptimizerTest, ARequestMakesAVersionEvenIfNothingHasChanged) {
  probe_.set_listening(Listening::kBroken);
  StartAll();
  ASSERT_OK_AND_ASSIGN(const OptimizedGraph first, optimizer_->Optimize(Soon(), site_));
  ASSERT_OK_AND_ASSIGN(const OptimizedGraph second, optimizer_->Optimize(Soon(), site_));
  EXPECT_EQ(second.version, first.version + 1);
  EXPECT_NEAR(second.solution.chi2_after, first.solution.chi2_after, 1e-9) << "solving twice changes nothing";
}

TEST_F(GraphOptimizerTest, ErrorsOfARequest) {
  StartAll();
  EXPECT_CODE(optimizer_->Optimize(Soon(), other_site_), absl::StatusCode::kFailedPrecondition) << "no maps";
  EXPECT_CODE(optimizer_->Optimize(Soon(), SiteId("nowhere")), absl::StatusCode::kNotFound);
  const auto lease = stores_.site_leases.Acquire(Soon(), other_site_, "a test", kSiteLeaseTime);
  ASSERT_OK(lease);
  EXPECT_TRUE(lease->has_value()) << "a failed request keeps no lease";
}

TEST_F(GraphOptimizerTest, SolvesAgainIfTheGraphWasEditedMeanwhile) {
  StartAll();
  std::atomic<int> edits{1};
  probe_.set_before_apply([&] {
    if (edits-- > 0) MoveDoor(10.2);
  });
  ASSERT_OK_AND_ASSIGN(const OptimizedGraph optimized, optimizer_->Optimize(Soon(), site_));
  EXPECT_EQ(probe_.locked_solves(), 0);
  EXPECT_NEAR(optimized.solution.map_poses.at(MapId("c")).pose.x, 20.267, 0.005) << "the solution includes the edit";
  ASSERT_OK_AND_ASSIGN(const auto versions, stores_.graphs.ListVersions(Soon(), site_, optimized.version + 1, 2));
  EXPECT_EQ(versions[0].cause, storage::GraphCause::kOptimized);
  EXPECT_EQ(versions[1].cause, storage::GraphCause::kLinkPointChanged);
}

TEST_F(GraphOptimizerTest, LocksTheGraphIfItIsEditedBeforeEveryAttempt) {
  probe_.set_listening(Listening::kBroken);  // only the request optimises
  StartAll();
  double x = 10;
  probe_.set_before_apply([&] { MoveDoor(x += 0.05); });
  ASSERT_OK_AND_ASSIGN(const OptimizedGraph optimized, optimizer_->Optimize(Soon(), site_));
  EXPECT_EQ(probe_.applies(), 3);
  EXPECT_EQ(probe_.locked_solves(), 1);
  EXPECT_EQ(LastSolution(site_), optimized.version);
  EXPECT_NEAR(stores_.link_points.Get(Soon(), site_, LinkPointId("bc"))->point.anchors[0].T_map_place.x, 10.15, 1e-9);
  EXPECT_NEAR(optimized.solution.map_poses.at(MapId("c")).pose.x, 20.25, 0.005) << "all three edits are in it";
}

TEST_F(GraphOptimizerTest, NeverLocksAGraphThatTakesLongToSolve) {
  probe_.set_listening(Listening::kBroken);
  Start();
  optimizer_.emplace(probe_, GraphOptimizer::Leases{stores_.solver_leases, stores_.site_leases}, *graphs_, changed_,
                     std::chrono::milliseconds(0));
  double x = 10.0;
  probe_.set_before_apply([&] { MoveDoor(x += 0.05); });
  EXPECT_CODE(optimizer_->Optimize(Soon(), site_).status(), absl::StatusCode::kAborted);
  EXPECT_EQ(probe_.applies(), 3);
  EXPECT_EQ(probe_.locked_solves(), 0);
  probe_.set_before_apply({});
  EXPECT_OK(optimizer_->Optimize(Soon(), site_)) << "in a pause";
}

TEST_F(GraphOptimizerTest, AnErrorOfTheStoreIsReturnedWithoutAnotherAttempt) {
  probe_.set_listening(Listening::kBroken);
  StartAll();
  probe_.set_before_apply([&] { stores_.database.FailCalls(absl::UnavailableError("gone")); });
  EXPECT_CODE(optimizer_->Optimize(Soon(), site_), absl::StatusCode::kUnavailable);
  EXPECT_EQ(probe_.applies(), 1);
  EXPECT_EQ(probe_.locked_solves(), 0);
  stores_.database.FailCalls(absl::OkStatus());
}

TEST_F(GraphOptimizerTest, ARequestWaitsForTheLease) {
  probe_.set_listening(Listening::kBroken);
  StartAll();
  const storage::SiteLease lease = HoldLease();
  const absl::Status held =
      optimizer_->Optimize(storage::CallContext::WithTimeout(std::chrono::milliseconds(120)), site_).status();
  // On a busy machine the deadline may pass within the last call of the store.
  EXPECT_TRUE(absl::IsAborted(held) || absl::IsDeadlineExceeded(held)) << held;
  EXPECT_EQ(LastSolution(site_), 0);
  std::thread waiting([&] { EXPECT_OK(optimizer_->Optimize(Soon(), site_)); });
  EXPECT_OK(stores_.site_leases.Release(Soon(), lease));
  waiting.join();
  EXPECT_GT(LastSolution(site_), 0);
}

TEST_F(GraphOptimizerTest, DoorsAreJudgedWhileAGraphIsSolvedAndNotWhileASolutionIsStored) {
  probe_.set_listening(Listening::kBroken);
  StartAll();
  std::atomic<bool> free_while_stored{true};
  probe_.set_before_apply([&] { free_while_stored = IsLeaseFree(); });
  const auto solving = stores_.solver_leases.Acquire(Soon(), site_, "another process", kSiteLeaseTime);
  ASSERT_TRUE(solving.ok() && *solving);
  EXPECT_TRUE(IsLeaseFree()) << "another process solves the graph";
  ASSERT_OK(stores_.solver_leases.Release(Soon(), **solving));
  ASSERT_OK(optimizer_->Optimize(Soon(), site_));
  EXPECT_FALSE(free_while_stored);
  EXPECT_TRUE(IsLeaseFree());
}

TEST_F(GraphOptimizerTest, WhatWasSolvedWhileADoorWasJudgedIsNotSolvedAgain) {
  const CountingLeases leases(stores_.solver_leases);
  const storage::SiteLease judging = HoldLease();
  StartListening();
  optimizer_.emplace(probe_, GraphOptimizer::Leases{leases, stores_.site_leases}, *graphs_, changed_);
  MoveDoor(10.1);
  while (leases.count() < 2) std::this_thread::sleep_for(std::chrono::milliseconds(5));  // it comes back
  EXPECT_EQ(LastSolution(site_), 0);
  EXPECT_OK(stores_.site_leases.Release(Soon(), judging));
  AwaitSolution(site_, 0);
  optimizer_.reset();
}

TEST_F(GraphOptimizerTest, StopEndsTheWaitForTheLease) {
  probe_.set_listening(Listening::kBroken);
  StartAll();
  HoldLease();
  std::thread waiting([&] { EXPECT_CODE(optimizer_->Optimize(Soon(), site_), absl::StatusCode::kUnavailable); });
  optimizer_->Stop();
  waiting.join();
}

TEST_F(GraphOptimizerTest, OptimisesChangedGraphsByItself) {
  StartListening();
  StartOptimizer();
  const std::int64_t first = AwaitSolution(site_, 0);
  MoveDoor(10.3);
  const std::int64_t second = AwaitSolution(site_, first);
  const auto graph = AwaitVersion(second);
  EXPECT_EQ(graph->solution_version, second);
  EXPECT_NEAR(WorldXOfC(*graph), 20.3, 1e-6);
}

// The worker handles sites in the order of their ids: once "z" is solved, "campus" has been considered.
TEST_F(GraphOptimizerTest, ChangesThatNoSolutionDependsOnMakeNoVersion) {
  StartListening();
  StartOptimizer();
  const std::int64_t first = AwaitSolution(site_, 0);
  storage::StoredLinkPoint candidate = MakeDoor(site_, "candidate", "a", "b", {5, 0, 0});
  candidate.point.anchors.pop_back();
  ASSERT_OK(stores_.link_points.Create(Soon(), candidate, ""));
  ASSERT_OK_AND_ASSIGN(storage::Map map, stores_.maps.Get(Soon(), site_, MapId("b")));
  map.display_name = "Another name";
  ASSERT_OK(stores_.maps.Update(Soon(), map));
  AwaitVersion(Version());
  const SiteId last("z");
  stores_.database.AddSite(last);
  for (const char* id : {"a", "b"}) ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(last, id), ""));
  ASSERT_OK(stores_.link_points.Create(Soon(), MakeDoor(last, "ab", "a", "b", {1, 2, 3}), ""));
  AwaitSolution(last, 0);
  EXPECT_EQ(LastSolution(site_), first);
}

TEST_F(GraphOptimizerTest, TheWorkerDoesNotRepeatWhatARequestHasSolved) {
  const CountingLeases leases(stores_.solver_leases);
  StartListening();
  ASSERT_OK_AND_ASSIGN(const OptimizedGraph optimized, [&] {
    optimizer_.emplace(probe_, GraphOptimizer::Leases{leases, stores_.site_leases}, *graphs_, changed_);
    return optimizer_->Optimize(Soon(), site_);
  }());
  AwaitVersion(optimized.version);
  const int solved = leases.count();
  const SiteId last("z");  // comes after it
  stores_.database.AddSite(last);
  for (const char* id : {"a", "b"}) ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(last, id), ""));
  ASSERT_OK(stores_.link_points.Create(Soon(), MakeDoor(last, "ab", "a", "b", {1, 2, 3}), ""));
  AwaitSolution(last, 0);
  EXPECT_EQ(LastSolution(site_), optimized.version);
  EXPECT_EQ(leases.count(), solved + 1);
  optimizer_.reset();
}

TEST_F(GraphOptimizerTest, TheWorkerComesBackToASiteWhoseLeaseIsHeld) {
  const storage::SiteLease lease = HoldLease();
  StartListening();
  StartOptimizer();
  MoveDoor(10.1);
  const SiteId last("z");
  stores_.database.AddSite(last);
  for (const char* id : {"a", "b"}) ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(last, id), ""));
  ASSERT_OK(stores_.link_points.Create(Soon(), MakeDoor(last, "ab", "a", "b", {1, 2, 3}), ""));
  AwaitSolution(last, 0);
  EXPECT_EQ(LastSolution(site_), 0) << "held by another process";
  ASSERT_OK(stores_.site_leases.Release(Soon(), lease));
  AwaitSolution(site_, 0);  // without a further change
}

TEST_F(GraphOptimizerTest, TheWorkerTriesAgainAfterAnError) {
  StartListening();
  std::atomic<bool> failed{false};
  probe_.set_before_apply([&] {
    if (failed) return;
    stores_.database.FailCalls(absl::UnavailableError("gone"));
    failed = true;
  });
  StartOptimizer();
  while (!failed) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  stores_.database.FailCalls(absl::OkStatus());
  // The worker may not have been able to release the lease: it expires.
  stores_.database.AdvanceClock(std::chrono::minutes(1));
  AwaitSolution(site_, 0);
}

}  // namespace
}  // namespace enfilade::server
