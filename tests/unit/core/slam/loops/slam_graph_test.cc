// SPDX-License-Identifier: Apache-2.0
#include "core/slam/loops/slam_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "core/slam/loops/edge_information.h"
#include "core/slam/loops/loop_candidates.h"
#include "core/slam/matching/motion_model.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"

namespace enfilade::slam {
namespace {

using testing::PoseNear;

// Submaps along a square of 10 m sides, one keyframe in each, as measured with a yaw error of `drift` at each corner.
// Submap 4 is back where submap 0 was.
MapperState Square(double drift) {
  MapperState state;
  Pose2 pose;
  for (std::int64_t id = 0; id <= 4; ++id) {
    const std::vector<SubmapNode> nodes{{id, false, 10.0, {1.0, 0.0, 0.1}, InformationOf(0.01, 0.002)}};
    std::optional<NextSubmap> next;
    if (id < 4) next = NextSubmap{{10.0, 0.0, M_PI / 2.0 + drift}, InformationOf(0.05, 0.05)};
    state.finished[id] = FinishSubmap(pose, 1, "", nodes, next);
    SlamNode node;
    node.id = id;
    node.T_map_node = pose * nodes[0].T_submap_node;
    node.submap = id;
    state.nodes[id] = node;
    if (next) pose = pose * next->T_submap_next;
  }
  return state;
}

LoopClosure Closure(std::int64_t id, std::int64_t submap, std::int64_t node, const Pose2& T_submap_node) {
  LoopClosure closure;
  closure.id = id;
  closure.submap = submap;
  closure.node = node;
  closure.T_submap_node = T_submap_node;
  closure.information = InformationOf(0.05, 0.01);
  closure.state = LoopClosureState::kAccepted;
  return closure;
}

TEST(SolveSlamGraph, PullsADriftedSquareTogether) {
  MapperState state = Square(0.05);
  EXPECT_GT(state.nodes.at(4).T_map_node.translation().norm(), 1.5);
  state.loop_closures[0] = Closure(0, 0, 4, {1.0, 0.0, 0.1});  // keyframe 4 is where keyframe 0 was
  EXPECT_FALSE(SolveSlamGraph({}, state).nodes.empty());
  EXPECT_THAT(state.nodes.at(0).T_map_node, PoseNear(Pose2{1.0, 0.0, 0.1}, 1e-12, 1e-12)) << "held";
  EXPECT_THAT(state.nodes.at(4).T_map_node, PoseNear(Pose2{1.0, 0.0, 0.1}, 0.2, 0.05));
  EXPECT_EQ(state.loop_closures.at(0).state, LoopClosureState::kAccepted);
  for (const auto& [id, submap] : state.finished) {
    EXPECT_THAT(Between(submap.T_map_submap, state.nodes.at(id).T_map_node),
                PoseNear(Pose2{1.0, 0.0, 0.1}, 0.05, 0.01));
  }
}

TEST(SolveSlamGraph, SwitchesOffWhatContradictsTheRest) {
  MapperState state = Square(0.0);
  const std::map<std::int64_t, SlamNode> before = state.nodes;
  state.loop_closures[0] = Closure(0, 0, 4, {1.0, 0.0, 0.1});
  state.loop_closures[1] = Closure(1, 0, 4, {1.02, 0.01, 0.1});
  state.loop_closures[2] = Closure(2, 0, 2, {2.0, 1.0, 0.0});  // false: keyframe 2 is at the far corner
  SolveSlamGraph({}, state);
  EXPECT_EQ(state.loop_closures.at(0).state, LoopClosureState::kAccepted);
  EXPECT_EQ(state.loop_closures.at(1).state, LoopClosureState::kAccepted);
  EXPECT_EQ(state.loop_closures.at(2).state, LoopClosureState::kRejected);
  EXPECT_THAT(state.loop_closures.at(2).reason, ::testing::HasSubstr("chi2"));
  for (const auto& [id, node] : before) {
    EXPECT_THAT(state.nodes.at(id).T_map_node, PoseNear(node.T_map_node, 0.05, 0.01)) << id;
  }
}

TEST(SolveSlamGraph, LeavesSuspendedClosuresOut) {
  MapperState state = Square(0.05);
  const Pose2 before = state.nodes.at(4).T_map_node;
  state.loop_closures[0] = Closure(0, 0, 4, {1.0, 0.0, 0.1});
  state.loop_closures[0].state = LoopClosureState::kSuspended;
  SolveSlamGraph({}, state);
  EXPECT_THAT(state.nodes.at(4).T_map_node, PoseNear(before, 1e-6, 1e-6));
  EXPECT_EQ(state.loop_closures.at(0).state, LoopClosureState::kSuspended);
}

TEST(SolveSlamGraph, GivesCovariancesThatGrowAlongTheWay) {
  MapperState state = Square(0.0);
  SolveSlamGraph({}, state);
  EXPECT_TRUE(state.nodes.at(0).covariance.isZero());
  for (std::int64_t id = 1; id <= 4; ++id) {
    EXPECT_GT(state.nodes.at(id).covariance(2, 2), state.nodes.at(id - 1).covariance(2, 2));
  }
}

TEST(SolveSlamGraph, ScalesMeasuredCovariancesByWhatTheErrorsAre) {
  MapperState careful = Square(0.0);
  SolveSlamGraph({}, careful);
  MapperState accurate = Square(0.0);
  accurate.errors = {.match_squares = 4.0, .matches = 100};  // a fifth of the options' standard deviations
  SolveSlamGraph({}, accurate);
  for (std::int64_t id = 1; id <= 4; ++id) {
    const Eigen::Matrix3d expected = 0.04 * careful.nodes.at(id).covariance;
    EXPECT_LT((accurate.nodes.at(id).covariance - expected).norm(), 1e-6 * expected.norm()) << id;
    EXPECT_THAT(accurate.nodes.at(id).T_map_node, PoseNear(careful.nodes.at(id).T_map_node, 1e-12, 1e-12));
  }
}

TEST(SolveSlamGraph, DoesNotScaleTheTieOfALostRobot) {
  MapperState state = Square(0.0);
  state.finished.at(1).next->information = LostTie();
  state.errors = {.match_squares = 1.0, .matches = 100};
  SolveSlamGraph({}, state);
  EXPECT_LT(state.nodes.at(1).covariance(0, 0), 0.01);
  EXPECT_GT(state.nodes.at(2).covariance(0, 0), 99.0) << "10 m";
}

TEST(SolveSlamGraph, LearnsFromItsLoopClosures) {
  MapperState state = Square(0.0);
  state.errors = {.match_squares = 1.0, .matches = 100};
  const double before = VarianceFactor(state.errors);
  state.loop_closures[0] = Closure(0, 0, 4, {1.4, 0.0, 0.1});  // 0.4 m from where the way led
  SolveSlamGraph({}, state);
  EXPECT_EQ(state.errors.redundancy, 3);
  EXPECT_GT(state.errors.graph_chi2, 0.5);
  EXPECT_GT(VarianceFactor(state.errors), before);
  SolveSlamGraph({}, state);
  EXPECT_EQ(state.errors.redundancy, 3) << "counted once";
}

TEST(RelativeCovariances, AreThoseOfTheWayBetween) {
  MapperState state = Square(0.0);
  SolveSlamGraph({}, state);
  ASSERT_OK_AND_ASSIGN(const auto from_first, RelativeCovariances(state, 0, {0, 3, 4}));
  EXPECT_TRUE(from_first[0].isZero());
  EXPECT_LT((from_first[1] - InMeasurementFrame(state.nodes.at(3).covariance, state.nodes.at(0).T_map_node.yaw)).norm(),
            1e-9);
  ASSERT_OK_AND_ASSIGN(const auto from_last, RelativeCovariances(state, 3, {4}));
  EXPECT_LT(from_last[0](2, 2), from_first[2](2, 2)) << "one step, not four";
  EXPECT_CODE(RelativeCovariances(state, 0, {17}), absl::StatusCode::kInvalidArgument);
}

TEST(DriftLengths, GoTheShortestWayAcrossClosures) {
  MapperState state = Square(0.0);
  EXPECT_DOUBLE_EQ(DriftLengths(state, 4).at(0), 40.0);
  state.loop_closures[0] = Closure(0, 1, 4, {});
  Join(state.loop_closures[0], state);
  EXPECT_DOUBLE_EQ(DriftLengths(state, 4).at(0), 10.0);
  state.loop_closures[0].state = LoopClosureState::kRejected;
  JoinAll(state);
  EXPECT_DOUBLE_EQ(DriftLengths(state, 4).at(0), 40.0);
}

TEST(SelectLoopCandidates, TakesNearSubmapsThatAreNotTooRecentAndNotYetJoined) {
  MapperState state = Square(0.0);
  LoopOptions options;
  const SlamNode node = state.nodes.at(4);
  auto candidates = SelectLoopCandidates(state, node, options);
  ASSERT_EQ(candidates.size(), 1U);
  EXPECT_EQ(candidates[0].submap, 0);
  EXPECT_DOUBLE_EQ(candidates[0].half_width, options.search_base + 40.0 * options.drift_per_metre);
  options.min_submap_gap = 5;
  EXPECT_TRUE(SelectLoopCandidates(state, node, options).empty()) << "too recent";
  options = {};
  options.max_distance = 0.0;
  options.search_base = 0.05;
  options.drift_per_metre = 0.0;
  state.nodes.at(4).T_map_node.x += 3.0;
  EXPECT_TRUE(SelectLoopCandidates(state, state.nodes.at(4), options).empty()) << "too far";
  state.loop_closures[0] = Closure(0, 0, 4, {1.0, 0.0, 0.1});
  EXPECT_TRUE(SelectLoopCandidates(state, node, {}).empty()) << "closed already";
}

TEST(EdgeInformation, TurnsIntoTheMeasurementsFrame) {
  // Sure along x of frame a, unsure along y; frame b is turned by 90 degrees.
  const Eigen::Matrix3d information = Eigen::Vector3d(100.0, 1.0, 10.0).asDiagonal();
  const Eigen::Matrix3d turned = InMeasurementFrame(information, M_PI / 2.0);
  EXPECT_NEAR(turned(0, 0), 1.0, 1e-12);
  EXPECT_NEAR(turned(1, 1), 100.0, 1e-12);
  EXPECT_NEAR(turned(2, 2), 10.0, 1e-12);
}

TEST(EdgeInformation, AddsAFloorEvenWhereSingular) {
  Eigen::Matrix3d corridor = Eigen::Matrix3d::Zero();
  corridor(1, 1) = 1e6;
  corridor(2, 2) = 1e6;
  const Eigen::Matrix3d floored = WithFloor(corridor, 0.1, 0.01);
  EXPECT_NEAR(floored(1, 1), 1.0 / (0.01 + 1e-6), 1.0);
  EXPECT_GT(floored(0, 0), 0.0);
  EXPECT_EQ(Eigen::LLT<Eigen::Matrix3d>(floored).info(), Eigen::Success);
  EXPECT_GT(WeakestDirection(corridor), 100.0);
  EXPECT_NEAR(WeakestDirection(InformationOf(0.1, 0.1)), 0.1, 1e-6);
}

}  // namespace
}  // namespace enfilade::slam
