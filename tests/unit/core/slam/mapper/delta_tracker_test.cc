// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/delta_tracker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/core/slam/chain_of_submaps.h"

namespace enfilade::slam {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

class DeltaTrackerTest : public ::testing::Test {
 protected:
  DeltaTrackerTest() {
    for (auto& [id, submap] : state_.finished) submap.content = "content " + std::to_string(id);
    state_.loop_closures[0] = testing::MakeLoopClosure(0, 0, 2, {});
    state_.active = Submap{3, 7, {30.0, 1.0, 0.0}, {{}, {}, {}, SubmapGrid(0.05, {})}};
  }

  MapperState state_ = testing::MakeSubmapChain({.submaps = 3});
  DeltaTracker tracker_;
};

TEST_F(DeltaTrackerTest, IsEmptyBeforeAnyMark) { EXPECT_TRUE(tracker_.Take(state_).empty()); }

TEST_F(DeltaTrackerTest, TakesEachMarkedRowOnceAsItIsNow) {
  for (const std::int64_t id : {2, 0, 2, 2}) tracker_.MarkNode(id);
  tracker_.MarkLoopClosure(0);
  tracker_.MarkLoopClosure(0);
  state_.nodes.at(2).T_map_node.x = 77.0;  // after the mark
  state_.loop_closures.at(0).chi2 = 3.5;
  const SlamDelta delta = tracker_.Take(state_);
  EXPECT_THAT(delta.nodes, ElementsAre(state_.nodes.at(0), state_.nodes.at(2)));
  EXPECT_THAT(delta.loop_closures, ElementsAre(state_.loop_closures.at(0)));
  EXPECT_TRUE(delta.submaps.empty());
}

TEST_F(DeltaTrackerTest, ClearsItsMarks) {
  tracker_.MarkNode(1);
  tracker_.MarkContent(0);
  tracker_.Append({1, 2, 0, {}});
  EXPECT_FALSE(tracker_.Take(state_).empty());
  EXPECT_TRUE(tracker_.Take(state_).empty());
}

TEST_F(DeltaTrackerTest, SendsContentOnlyIfItChanged) {
  tracker_.MarkSubmap(0);
  tracker_.MarkContent(1);
  const SlamDelta delta = tracker_.Take(state_);
  ASSERT_THAT(delta.submaps, SizeIs(2));
  EXPECT_EQ(delta.submaps[0], (SlamSubmap{0, 1, state_.finished.at(0).T_map_submap, true, ""}));
  EXPECT_EQ(delta.submaps[1], (SlamSubmap{1, 1, state_.finished.at(1).T_map_submap, true, "content 1"}));
}

TEST_F(DeltaTrackerTest, SendsTheActiveSubmapWithoutContent) {
  tracker_.MarkSubmap(3);
  const SlamDelta delta = tracker_.Take(state_);
  EXPECT_THAT(delta.submaps, ElementsAre(SlamSubmap{3, 7, {30.0, 1.0, 0.0}, false, ""}));
}

TEST_F(DeltaTrackerTest, MarksAllThatASolutionChanged) {
  GraphChange change;
  change.nodes = {0, 1};
  change.submaps = {2};
  change.loop_closures = {0};
  tracker_.MarkNode(2);
  tracker_.Mark(change);
  const SlamDelta delta = tracker_.Take(state_);
  EXPECT_THAT(delta.nodes, SizeIs(3));
  ASSERT_THAT(delta.submaps, SizeIs(1));
  EXPECT_EQ(delta.submaps[0].id, 2);
  EXPECT_EQ(delta.submaps[0].content, "") << "only its pose changed";
  EXPECT_THAT(delta.loop_closures, SizeIs(1));
}

TEST_F(DeltaTrackerTest, KeepsThePointsOfTheTrajectoryInOrder) {
  const TrajectoryPoint points[] = {{5, 100, 0, {0.1, 0.0, 0.0}}, {6, 200, 0, {0.2, 0.0, 0.0}}, {9, 300, 1, {}}};
  for (const TrajectoryPoint& point : points) tracker_.Append(point);
  EXPECT_THAT(tracker_.Take(state_).trajectory, ElementsAre(points[0], points[1], points[2]));
}

// What the caller stores: applied in turn, the deltas give the rows of the state.
TEST_F(DeltaTrackerTest, AddUpToTheState) {
  SlamMap map;
  for (std::int64_t id = 0; id < 3; ++id) {
    tracker_.MarkNode(id);
    tracker_.MarkContent(id);
  }
  map.Apply(tracker_.Take(state_));
  state_.finished.at(1).T_map_submap = {5.0, 5.0, 5.0};
  tracker_.MarkSubmap(1);
  tracker_.MarkLoopClosure(0);
  map.Apply(tracker_.Take(state_));
  EXPECT_EQ(map.nodes, state_.nodes);
  EXPECT_EQ(map.loop_closures, state_.loop_closures);
  for (const auto& [id, submap] : state_.finished) {
    EXPECT_EQ(map.submaps.at(id).T_map_submap, submap.T_map_submap);
    EXPECT_EQ(map.submaps.at(id).content, submap.content) << "a later row without content keeps it";
  }
}

}  // namespace
}  // namespace enfilade::slam
