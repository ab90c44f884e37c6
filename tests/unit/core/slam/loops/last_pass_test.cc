// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/last_pass.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/slam/mapper/mapper.h"
#include "tests/unit/core/slam/chain_of_submaps.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

std::vector<std::pair<std::int64_t, std::int64_t>> AllPairs(LastPass pass, const MapperState& state) {
  std::vector<std::pair<std::int64_t, std::int64_t>> pairs;
  while (const auto pair = pass.Next(state)) pairs.emplace_back(pair->earlier, pair->later);
  return pairs;
}

// Around a hexagon and on: submap k + 6 lies where submap k does.
MapperState MakeRound() { return testing::MakeSubmapChain({.submaps = 9, .T_submap_next = {10.0, 0.0, M_PI / 3.0}}); }

SlamOptions Narrow() {
  SlamOptions options;
  options.loop.max_distance = 1.0;
  options.loop.drift_per_metre = 0.0;
  return options;
}

TEST(LastPassTest, GivesPairsThatOverlapAndThatTheGraphTiesByALongWayOnly) {
  const MapperState state = MakeRound();
  LastPass pass(Narrow());
  for (const auto& [earlier, later] : AllPairs(pass, state)) EXPECT_GE(later - earlier, 5) << earlier << " " << later;
  SlamOptions never = Narrow();
  never.loop.last_pass_length = 1000.0;
  EXPECT_TRUE(AllPairs(LastPass(never), state).empty());
}

TEST(LastPassTest, GivesEachPairOnceAlsoWhenTheGraphHasChanged) {
  const MapperState state = MakeRound();
  LastPass pass(Narrow());
  const auto first = pass.Next(state);
  ASSERT_TRUE(first);
  pass.Forget();
  for (const auto& [earlier, later] : AllPairs(pass, state)) {
    EXPECT_FALSE(earlier == first->earlier && later == first->later);
  }
}

TEST(LastPassTest, LeavesOutWhatAClosureHasJoinedMeanwhile) {
  MapperState state = MakeRound();
  const std::size_t before = AllPairs(LastPass(Narrow()), state).size();
  state.joined[1].insert(7);
  state.joined[7].insert(1);
  const auto after = AllPairs(LastPass(Narrow()), state);
  EXPECT_LT(after.size(), before);
  for (const auto& pair : after) EXPECT_NE(pair, std::pair(std::int64_t{1}, std::int64_t{7}));
}

// The robot comes back to where it began, and its log ends soon after.
TEST(LastPassTest, JoinsWhatNoScanHasJoined) {
  const auto walls = testing::WallsFromText({"##################",  //
                                             "#   #       ##   #",  //
                                             "#                #",  //
                                             "#   ########     #",  //
                                             "#   #      #    ##",  //
                                             "##  #      ##    #",  //
                                             "#   ########     #",  //
                                             "#             #  #",  //
                                             "#    #    #      #",  //
                                             "##################"},
                                            1.5);
  const auto log = testing::Record(walls, testing::Drive({{3, 3}, {21, 3}, {21, 11}, {3, 11}, {3, 3}, {9, 3}}, 0.25),
                                   {}, {0.02, 0.01}, 3);
  SlamOptions options;
  options.loop.max_attempts = 0;  // while it records
  const auto count_accepted = [&log](const SlamOptions& used) {
    Mapper mapper(used);
    for (const sensor::PairedScan& scan : log) mapper.AddScan(scan);
    mapper.Finish();
    int accepted = 0;
    std::int64_t last = -1;
    for (const LoopClosure& closure : mapper.TakeDelta().loop_closures) {
      if (closure.state == LoopClosureState::kAccepted) ++accepted;
      last = std::max(last, closure.id);
    }
    mapper.Finish();
    for (const LoopClosure& closure : mapper.TakeDelta().loop_closures) {
      EXPECT_LE(closure.id, last) << "nothing is tried again";
    }
    return accepted;
  };
  EXPECT_GE(count_accepted(options), 1);
  options.loop.last_pass_length = 1000.0;
  EXPECT_EQ(count_accepted(options), 0);
}

}  // namespace
}  // namespace enfilade::slam
