// SPDX-License-Identifier: Apache-2.0
#include "core/slam/state/mapper_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/core/slam/chain_of_submaps.h"

namespace enfilade::slam {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::MakeLoopClosure;
using ::testing::Pair;
using ::testing::UnorderedElementsAre;

class MapperStateTest : public ::testing::Test {
 protected:
  void Close(std::int64_t submap, std::int64_t node, LoopClosureState as = LoopClosureState::kAccepted) {
    const auto id = static_cast<std::int64_t>(state_.loop_closures.size());
    LoopClosure closure = MakeLoopClosure(id, submap, node, {});
    closure.state = as;
    state_.loop_closures[id] = closure;
    Join(closure, state_);
  }

  MapperState state_ = testing::MakeSubmapChain({.submaps = 6});
};

TEST_F(MapperStateTest, JoinsSubmapsInBothDirections) {
  Close(0, 4);
  Close(4, 1);
  EXPECT_THAT(state_.joined,
              UnorderedElementsAre(Pair(0, ElementsAre(4)), Pair(4, ElementsAre(0, 1)), Pair(1, ElementsAre(4))));
}

TEST_F(MapperStateTest, JoinsByAcceptedClosuresOnly) {
  Close(0, 4, LoopClosureState::kRejected);
  Close(1, 5, LoopClosureState::kSuspended);
  EXPECT_THAT(state_.joined, IsEmpty());
}

TEST_F(MapperStateTest, JoinAllForgetsClosuresThatNoLongerHold) {
  Close(0, 4);
  Close(1, 5);
  const auto both = state_.joined;
  JoinAll(state_);
  EXPECT_EQ(state_.joined, both) << "the same as one by one";
  state_.loop_closures.at(0).state = LoopClosureState::kRejected;
  JoinAll(state_);
  EXPECT_THAT(state_.joined, UnorderedElementsAre(Pair(1, ElementsAre(5)), Pair(5, ElementsAre(1))));
}

TEST_F(MapperStateTest, IsRecognisedByAClosureAcrossTheBorder) {
  EXPECT_FALSE(IsRecognised(state_, 3));
  Close(0, 2);
  EXPECT_FALSE(IsRecognised(state_, 3)) << "both before";
  Close(3, 5);
  EXPECT_FALSE(IsRecognised(state_, 3)) << "both after";
  Close(1, 4, LoopClosureState::kRejected);
  EXPECT_FALSE(IsRecognised(state_, 3)) << "not accepted";
  Close(1, 4);
  EXPECT_TRUE(IsRecognised(state_, 3));
  EXPECT_FALSE(IsRecognised(state_, 0)) << "nothing is before the first submap";
}

TEST_F(MapperStateTest, IsRecognisedAlsoByAnEarlierKeyframeInALaterSubmap) {
  Close(4, 1);
  EXPECT_TRUE(IsRecognised(state_, 3));
}

TEST_F(MapperStateTest, KnowsItsLastSubmapAndTheExistingMap) {
  EXPECT_EQ(state_.last_submap(), 5);
  state_.active = Submap{6, 0, {}, {{}, {}, {}, SubmapGrid(0.05, {})}};
  EXPECT_EQ(state_.last_submap(), 6);
  EXPECT_EQ(MapperState{}.last_submap(), -1);
  EXPECT_FALSE(state_.is_existing_map(0));
  state_.entry.emplace();
  EXPECT_TRUE(state_.is_existing_map(0));
  EXPECT_FALSE(state_.is_existing_map(1));
}

TEST_F(MapperStateTest, CountsTheBytesThatGrow) {
  const std::size_t before = KeptBytes(state_);
  state_.finished.at(2).content = std::string(50'000, 'c');
  const std::size_t with_content = KeptBytes(state_);
  EXPECT_GE(with_content, before + 49'900) << "an empty string has some room, too";
  Close(0, 4);
  state_.loop_closures.at(0).reason = std::string(1'000, 'r');
  const std::size_t with_closure = KeptBytes(state_);
  EXPECT_GE(with_closure, with_content + 1'000 + sizeof(LoopClosure));
  state_.nodes[6].id = 6;
  EXPECT_GE(KeptBytes(state_), with_closure + sizeof(SlamNode));
  EXPECT_EQ(KeptBytes(MapperState{}), 0U);
}

}  // namespace
}  // namespace enfilade::slam
