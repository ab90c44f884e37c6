// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/loop_closer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/slam/submaps/robot_rays.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/chain_of_submaps.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::PoseNear;
using ::testing::SizeIs;

// A drive around a square; the last submap has come back to a room that submap 0 knows. The estimate is off by kDrift.
class TryLoopClosuresTest : public ::testing::Test {
 protected:
  static constexpr Pose2 kDrift{0.4, -0.3, 0.08};
  static constexpr Pose2 kTruth{5.0, 2.0, 0.3};  // of the node, in submap 0

  TryLoopClosuresTest() {
    SubmapContent content{{}, {}, {}, SubmapGrid(0.05, {})};
    for (const Pose2& pose : {Pose2{2.0, 2.0, 0.0}, Pose2{5.0, 2.5, 1.5}, Pose2{6.0, 2.0, -2.0}}) {
      EXPECT_OK(content.grid.Insert(pose, RaysFrom(pose)));
    }
    state_.finished.at(0).content = Encode(content);
    node_ = state_.nodes.at(4);
    node_.T_map_node = kTruth * kDrift;
    state_.nodes[4] = node_;
    options_.loop.max_distance = 6.0;
  }

  grid::ScanRays RaysFrom(const Pose2& pose) const {
    return RobotRays(testing::Scan(walls_, pose, {.beams = 360, .field_of_view = 6.28}, 0, 2), {});
  }

  std::vector<LoopClosure> Try(const grid::ScanRays& rays) {
    return TryLoopClosures(state_, node_, rays, options_, cache_);
  }

  const std::vector<testing::Wall> walls_ = testing::WallsFromText({"#########",  //
                                                                    "#   #   #",  //
                                                                    "#      ##",  //
                                                                    "#       #",  //
                                                                    "#########"},
                                                                   1.0);
  SlamOptions options_;
  MapperState state_ =
      testing::MakeSubmapChain({.submaps = 5, .T_submap_next = {20.0, 0.0, M_PI / 2.0}, .length = 5.0});
  SlamNode node_;
  SubmapCache cache_{options_};
};

TEST_F(TryLoopClosuresTest, CorrectsTheNodesPoseInTheSubmap) {
  const std::vector<LoopClosure> closures = Try(RaysFrom(kTruth));
  ASSERT_THAT(closures, SizeIs(1));
  const LoopClosure& closure = closures[0];
  EXPECT_EQ(closure.state, LoopClosureState::kAccepted) << closure.reason;
  EXPECT_EQ(closure.submap, 0);
  EXPECT_EQ(closure.node, 4);
  EXPECT_THAT(closure.T_submap_node, PoseNear(kTruth, 0.03, 0.01));
  EXPECT_GT(closure.score, 0.8);
  EXPECT_GT(closure.information(0, 0), 0.0);
  EXPECT_EQ(closure.chi2, 0.0) << "not yet in the graph";
}

TEST_F(TryLoopClosuresTest, DoesNotDependOnWhereTheMapHasTheSubmap) {
  const Pose2 moved{-30.0, 12.0, 2.0};
  state_.finished.at(0).T_map_submap = moved;
  node_.T_map_node = moved * kTruth * kDrift;
  const std::vector<LoopClosure> closures = Try(RaysFrom(kTruth));
  ASSERT_THAT(closures, SizeIs(1));
  EXPECT_THAT(closures[0].T_submap_node, PoseNear(kTruth, 0.03, 0.01));
}

TEST_F(TryLoopClosuresTest, ReportsARejectedAttemptWithItsReason) {
  const std::vector<testing::Wall> elsewhere = testing::WallsFromText({"#####",  //
                                                                       "# # #",  //
                                                                       "#   #",  //
                                                                       "#####"},
                                                                      1.0);
  const grid::ScanRays rays =
      RobotRays(testing::Scan(elsewhere, {1.5, 1.5, 0.0}, {.beams = 360, .field_of_view = 6.28}, 0, 2), {});
  const std::vector<LoopClosure> closures = Try(rays);
  ASSERT_THAT(closures, SizeIs(1));
  EXPECT_EQ(closures[0].state, LoopClosureState::kRejected);
  EXPECT_THAT(closures[0].reason, Not(IsEmpty()));
  EXPECT_TRUE(closures[0].information.isZero()) << "it cannot enter the graph";
}

TEST_F(TryLoopClosuresTest, ContinuesTheIdsOfTheState) {
  for (std::int64_t id = 0; id < 3; ++id) state_.loop_closures[id] = testing::MakeLoopClosure(id, 2, -100, {});
  const std::vector<LoopClosure> closures = Try({});
  ASSERT_THAT(closures, SizeIs(1));
  EXPECT_EQ(closures[0].id, 3);
  EXPECT_THAT(closures[0].reason, HasSubstr("0 points, fewer than 30"));
}

TEST_F(TryLoopClosuresTest, TriesNothingWithoutCandidates) {
  options_.loop.min_submap_gap = 100;
  EXPECT_THAT(Try(RaysFrom(kTruth)), IsEmpty());
  EXPECT_EQ(cache_.bytes(), 0U) << "no submap was decompressed";
}

}  // namespace
}  // namespace enfilade::slam
