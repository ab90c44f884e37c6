// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/reconsider.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/pose_matchers.h"
#include "tests/unit/core/slam/chain_of_submaps.h"

namespace enfilade::slam {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::PoseNear;

// The pose of what follows submap 3, truly, in the frame where the estimate has it: the tie from 3 to 4 is wrong.
const Pose2 kTrueFromEstimated{1.5, -2.0, 0.12};

// The true pose of keyframe `node`, after submap 3, in `submap`, up to 3.
Pose2 Truth(const MapperState& state, std::int64_t submap, std::int64_t node) {
  return Between(state.finished.at(submap).T_map_submap, kTrueFromEstimated * state.nodes.at(node).T_map_node);
}

// Around a hexagon and on: keyframe k + 6 is where submap k was. Closures that tell so were rejected.
MapperState RoundWithASlip(int closures) {
  MapperState state = testing::MakeSubmapChain({.submaps = 10, .T_submap_next = {10.0, 0.0, M_PI / 3.0}});
  for (int k = 0; k < closures; ++k) {
    state.loop_closures[k] = testing::MakeLoopClosure(k, k, k + 6, Truth(state, k, k + 6));
    state.loop_closures[k].state = LoopClosureState::kRejected;
  }
  return state;
}

TEST(FindAgreeingClosures, FindsThoseThatTellTheSame) {
  MapperState state = RoundWithASlip(4);
  state.loop_closures[4] = testing::MakeLoopClosure(4, 1, 8, Truth(state, 1, 8) * Pose2{3.0, 1.0, 0.0});
  state.loop_closures[4].state = LoopClosureState::kRejected;
  EXPECT_THAT(FindAgreeingClosures(state, {}), ElementsAre(0, 1, 2, 3));
}

TEST(FindAgreeingClosures, WantsSeveralFromDifferentPlaces) {
  EXPECT_THAT(FindAgreeingClosures(RoundWithASlip(2), {}), IsEmpty());
  MapperState state = RoundWithASlip(1);
  for (int k = 1; k < 4; ++k) {
    state.loop_closures[k] = state.loop_closures[0];
    state.loop_closures[k].id = k;
  }
  EXPECT_THAT(FindAgreeingClosures(state, {}), IsEmpty()) << "one view, four times";
}

TEST(FindAgreeingClosures, LeavesOutWhatWasNotMatched) {
  MapperState state = RoundWithASlip(4);
  for (auto& [id, closure] : state.loop_closures) closure.information.setZero();
  EXPECT_THAT(FindAgreeingClosures(state, {}), IsEmpty());
}

TEST(LoosenTies, LetsAgreeingClosuresHoldAgainstAWrongTie) {
  MapperState refused = RoundWithASlip(4);
  SolveSlamGraph({}, refused);
  EXPECT_EQ(refused.loop_closures.at(0).state, LoopClosureState::kRejected) << "the ties are believed";

  MapperState state = RoundWithASlip(4);
  const MapperState before = state;
  const auto ties = LoosenTies({}, {0, 1, 2, 3}, state);
  ASSERT_FALSE(ties.empty());
  for (const auto& [id, information] : ties) {
    EXPECT_LT(information(0, 0), state.finished.at(id).next->information(0, 0));
    state.finished.at(id).next->information = information;
  }
  SolveSlamGraph({}, state);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(state.loop_closures.at(k).state, LoopClosureState::kAccepted) << k;
    const Pose2 found = Between(state.finished.at(k).T_map_submap, state.nodes.at(k + 6).T_map_node);
    EXPECT_THAT(found, PoseNear(Truth(before, k, k + 6), 0.2, 0.03)) << k;
  }
}

TEST(LoosenTies, ChangesNothingIfTheTiesFit) {
  MapperState state = testing::MakeSubmapChain({.submaps = 10, .T_submap_next = {10.0, 0.0, M_PI / 3.0}});
  state.loop_closures[0] = testing::MakeLoopClosure(0, 0, 6, {1.0, 0.0, 0.0});
  EXPECT_THAT(LoosenTies({}, {0}, state), IsEmpty());
}

}  // namespace
}  // namespace enfilade::slam
