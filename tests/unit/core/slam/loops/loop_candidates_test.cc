// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/loop_candidates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/unit/core/slam/chain_of_submaps.h"

namespace enfilade::slam {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::MakeLoopClosure;
using testing::MakeSubmapChain;

std::vector<std::int64_t> SubmapsOf(const std::vector<LoopCandidate>& candidates) {
  std::vector<std::int64_t> ids;
  for (const LoopCandidate& candidate : candidates) ids.push_back(candidate.submap);
  return ids;
}

// All pairs by Floyd and Warshall.
std::vector<std::vector<double>> AllLengths(const MapperState& state) {
  const std::size_t n = state.finished.size() + 1;
  std::vector<std::vector<double>> d(n, std::vector<double>(n, std::numeric_limits<double>::infinity()));
  for (std::size_t i = 0; i < n; ++i) d[i][i] = 0.0;
  for (const auto& [id, submap] : state.finished) {
    const auto i = static_cast<std::size_t>(id);
    d[i][i + 1] = d[i + 1][i] = submap.length;
  }
  for (const auto& [id, closure] : state.loop_closures) {
    if (closure.state != LoopClosureState::kAccepted) continue;
    const auto a = static_cast<std::size_t>(closure.submap);
    const auto b = static_cast<std::size_t>(state.nodes.at(closure.node).submap);
    d[a][b] = d[b][a] = 0.0;
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) d[i][j] = std::min(d[i][j], d[i][k] + d[k][j]);
    }
  }
  return d;
}

TEST(DriftLengths, AreTheShortestPathsOverRandomLoopClosures) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    MapperState state = MakeSubmapChain({.submaps = 12});
    std::uniform_int_distribution<std::int64_t> any(0, 11);
    std::uniform_real_distribution<double> length(0.5, 20.0);
    for (auto& [id, submap] : state.finished) submap.length = length(random);
    for (std::int64_t id = 0; id < 4; ++id) {
      LoopClosure closure = MakeLoopClosure(id, any(random), any(random), {});
      if (id == 3) closure.state = LoopClosureState::kRejected;
      state.loop_closures[id] = closure;
    }
    JoinAll(state);
    const auto expected = AllLengths(state);
    for (std::int64_t from = 0; from <= 12; ++from) {
      const std::vector<double> lengths = DriftLengths(state, from);
      ASSERT_EQ(lengths.size(), 13U);
      for (std::size_t to = 0; to < lengths.size(); ++to) {
        EXPECT_NEAR(lengths[to], expected[static_cast<std::size_t>(from)][to], 1e-9)
            << "seed " << seed << ", " << from << " -> " << to;
      }
    }
  }
}

// Submaps twice around a square of 10 m: 8 is where 4 and 0 were.
class SelectLoopCandidatesTest : public ::testing::Test {
 protected:
  SelectLoopCandidatesTest() { state_.finished.at(4).T_map_submap.x -= 0.1; }  // a little farther than submap 0

  std::vector<LoopCandidate> Select() const { return SelectLoopCandidates(state_, node(), options_); }
  const SlamNode& node() const { return state_.nodes.at(8); }

  // An attempt from an earlier node.
  void Tried(std::int64_t submap, std::int64_t node, LoopClosureState as) {
    const auto id = static_cast<std::int64_t>(state_.loop_closures.size());
    LoopClosure closure = MakeLoopClosure(id, submap, node, {});
    closure.state = as;
    state_.loop_closures[id] = closure;
    Join(closure, state_);
  }

  MapperState state_ = MakeSubmapChain({.submaps = 9, .T_submap_next = {10.0, 0.0, M_PI / 2.0}});
  LoopOptions options_{.attempt_spacing = 3,
                       .accepted_spacing = 10,
                       .attempt_interval = 2,
                       .closure_spacing = 6,
                       .max_attempts = 10,
                       .max_distance = 1.0,
                       .search_base = 0.5,
                       .drift_per_metre = 0.0};
};

TEST_F(SelectLoopCandidatesTest, TakesTheSubmapsNearby) {
  EXPECT_THAT(SubmapsOf(Select()), ElementsAre(0, 4)) << "8 itself is too recent";
}

TEST_F(SelectLoopCandidatesTest, SortsByDistanceAndTakesTheNearest) {
  state_.finished.at(0).T_map_submap.x -= 0.3;
  auto candidates = Select();
  EXPECT_THAT(SubmapsOf(candidates), ElementsAre(4, 0));
  EXPECT_NEAR(candidates[0].distance, 0.1, 1e-9);
  EXPECT_NEAR(candidates[1].distance, 0.3, 1e-9);
  options_.max_attempts = 1;
  EXPECT_THAT(SubmapsOf(Select()), ElementsAre(4));
}

TEST_F(SelectLoopCandidatesTest, LeavesOutTheMostRecentSubmaps) {
  options_.min_submap_gap = 4;
  EXPECT_THAT(SubmapsOf(Select()), ElementsAre(0, 4));
  options_.min_submap_gap = 5;
  EXPECT_THAT(SubmapsOf(Select()), ElementsAre(0));
  options_.min_submap_gap = 9;
  EXPECT_THAT(SubmapsOf(Select()), IsEmpty());
}

TEST_F(SelectLoopCandidatesTest, WidensTheSearchByThePossibleDriftUpToItsLimit) {
  options_.drift_per_metre = 0.03;
  options_.yaw_drift_per_metre = 0.002;
  auto candidates = Select();
  ASSERT_GE(candidates.size(), 2U);
  for (const LoopCandidate& candidate : candidates) {
    const double drifted = 10.0 * static_cast<double>(8 - candidate.submap);
    EXPECT_NEAR(candidate.half_width, 0.5 + 0.03 * drifted, 1e-9);
    EXPECT_NEAR(candidate.half_angle, options_.search_angle_base + 0.002 * drifted, 1e-9);
    EXPECT_FALSE(candidate.is_entry);
  }
  options_.drift_per_metre = 1.0;
  options_.yaw_drift_per_metre = 1.0;
  for (const LoopCandidate& candidate : Select()) {
    EXPECT_LE(candidate.half_width, options_.max_search);
    EXPECT_LE(candidate.half_angle, M_PI);
  }
}

TEST_F(SelectLoopCandidatesTest, ReachesAsFarAsTheDriftMayBe) {
  state_.nodes.at(8).T_map_node.x += 3.0;
  EXPECT_THAT(SubmapsOf(Select()), IsEmpty()) << "3 m away, beyond 1 m and the search's 0.5 m";
  options_.drift_per_metre = 0.03;  // 0.5 m + 40 m * 0.03 = 1.7 m for submap 4, 2.9 m for submap 0
  EXPECT_THAT(SubmapsOf(Select()), ElementsAre(0));
}

struct Attempt {
  const char* name;
  std::int64_t submap;
  std::int64_t node;
  LoopClosureState state;
  std::vector<std::int64_t> expected;  // candidates for node 8
};

class SelectAfterAttempt : public SelectLoopCandidatesTest, public ::testing::WithParamInterface<Attempt> {};

TEST_P(SelectAfterAttempt, KeepsTheSpacing) {
  Tried(GetParam().submap, GetParam().node, GetParam().state);
  EXPECT_EQ(SubmapsOf(Select()), GetParam().expected);
}

INSTANTIATE_TEST_SUITE_P(Attempts, SelectAfterAttempt,
                         ::testing::Values(Attempt{"JustNow", 2, 7, LoopClosureState::kRejected, {}},
                                           Attempt{"LongEnoughAgoElsewhere", 2, 6, LoopClosureState::kRejected, {0, 4}},
                                           Attempt{"TooRecentlyTheSame", 0, 6, LoopClosureState::kRejected, {4}},
                                           Attempt{"LongEnoughAgoTheSame", 0, 5, LoopClosureState::kRejected, {0, 4}},
                                           Attempt{"ClosedWithAny", 2, 3, LoopClosureState::kAccepted, {}},
                                           Attempt{"ClosedWithAnyLongAgo", 2, 2, LoopClosureState::kAccepted, {0, 4}},
                                           Attempt{"ClosedWithTheSame", 4, 1, LoopClosureState::kAccepted, {0}},
                                           Attempt{"SuspendedCountsAsTried", 0, 6, LoopClosureState::kSuspended, {4}}),
                         [](const ::testing::TestParamInfo<Attempt>& attempt) {
                           return std::string(attempt.param.name);
                         });

TEST_F(SelectLoopCandidatesTest, OfNoSubmapsAreNone) {
  EXPECT_THAT(SelectLoopCandidates(MapperState{}, SlamNode{}, options_), IsEmpty());
}

// Submap 0 is an existing map of 4 m x 4 m; the robot entered it and has made two submaps since.
class SelectInExistingMapTest : public ::testing::Test {
 protected:
  SelectInExistingMapTest() {
    state_.entry = ExistingMapEntry{{{}, Eigen::Vector3d(0.04, 0.01, 0.0025).asDiagonal()}, std::nullopt};
    FinishedSubmap& existing = state_.finished.at(0);
    existing.nodes.clear();
    existing.length = 0.0;
    existing.known = Eigen::AlignedBox2d(Eigen::Vector2d(-1.0, -2.0), Eigen::Vector2d(3.0, 2.0));
    state_.nodes.erase(0);
  }

  std::vector<LoopCandidate> SelectAt(const Pose2& T_map_node) {
    state_.nodes.at(1).T_map_node = T_map_node;
    return SelectLoopCandidates(state_, state_.nodes.at(1), options_);
  }

  MapperState state_ = MakeSubmapChain({.submaps = 2, .T_submap_next = {0.5, 0.0, 0.0}});
  LoopOptions options_{.max_distance = 1.0, .search_base = 0.5, .search_angle_base = 0.15};
};

TEST_F(SelectInExistingMapTest, IsACandidateFromTheFirstKeyframeOnAsWideAsTheEntry) {
  const auto candidates = SelectAt({0.0, 0.0, 0.0});
  ASSERT_THAT(SubmapsOf(candidates), ElementsAre(0)) << "though it is only one submap back";
  EXPECT_TRUE(candidates[0].is_entry);
  EXPECT_EQ(candidates[0].distance, 0.0) << "inside the known box";
  EXPECT_NEAR(candidates[0].half_width, 0.5 + 3.0 * 0.2, 1e-9);
  EXPECT_NEAR(candidates[0].half_angle, 0.15 + 3.0 * 0.05, 1e-9);
}

TEST_F(SelectInExistingMapTest, IsSearchedLikeAnySubmapOnceTheRobotWasFoundInIt) {
  LoopClosure closure = MakeLoopClosure(0, 0, 1, {});
  Join(closure, state_);
  const auto candidates = SelectAt({0.0, 0.0, 0.0});
  ASSERT_THAT(SubmapsOf(candidates), ElementsAre(0));
  EXPECT_FALSE(candidates[0].is_entry);
  EXPECT_NEAR(candidates[0].half_width, 0.5, 1e-9);
}

TEST_F(SelectInExistingMapTest, IsNoCandidateFarFromItsKnownCells) {
  const double reach = 1.0 + 0.5 + 0.6;  // max_distance and the search's half-width
  EXPECT_THAT(SubmapsOf(SelectAt({3.0 + reach - 0.01, 0.0, 0.0})), ElementsAre(0));
  EXPECT_THAT(SubmapsOf(SelectAt({3.0 + reach + 0.01, 0.0, 0.0})), IsEmpty());
}

TEST_F(SelectInExistingMapTest, IsNoCandidateIfItIsEmpty) {
  state_.finished.at(0).known.setEmpty();
  EXPECT_THAT(SelectAt({0.0, 0.0, 0.0}), IsEmpty());
}

}  // namespace
}  // namespace enfilade::slam
