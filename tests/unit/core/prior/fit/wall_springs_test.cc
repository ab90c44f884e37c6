// SPDX-License-Identifier: Apache-2.0
#include "core/prior/correction/wall_springs.h"

#include <gtest/gtest.h>

namespace enfilade::prior {
namespace {

// An L: a wall of 10 m along x from corner 0 to 1, and one of 5 m along y from there to 2.
const std::vector<Eigen::Vector2d> kCorners = {{0, 0}, {10, 0}, {10, 5}};
const std::vector<WallSpring> kWalls = {{0, 1}, {1, 2}};

PlanOffset OffsetOf(int from, int to, double fraction, const Eigen::Vector2d& normal, double offset) {
  const Eigen::Vector2d a = kCorners[static_cast<std::size_t>(from)];
  const Eigen::Vector2d b = kCorners[static_cast<std::size_t>(to)];
  return {.place = {a + fraction * (b - a), {from, to}, {1 - fraction, fraction}},
          .normal = normal,
          .offset = offset,
          .sigma = 0.02};
}

TEST(WallSprings, AWallsOffsetMovesBothOfItsCorners) {
  const WallSprings springs({}, kCorners, kWalls,
                            {OffsetOf(0, 1, 0.25, {0, 1}, 0.3), OffsetOf(0, 1, 0.75, {0, 1}, 0.3)}, {});
  EXPECT_NEAR(springs.MeanAt({kCorners[0], {0, -1}, {1, 0}}).y(), 0.3, 0.01);
  EXPECT_NEAR(springs.MeanAt({kCorners[1], {1, -1}, {1, 0}}).y(), 0.3, 0.01);
  // The other wall is carried along, and its far end is the less certain.
  const Displacement far = springs.At({kCorners[2], {2, -1}, {1, 0}});
  EXPECT_NEAR(far.mean.y(), 0.3, 0.02);
  EXPECT_GT(far.covariance(1, 1), 0.4);
}

TEST(WallSprings, WallsStretchMoreEasilyThanTheyTurn) {
  const WallSprings springs({}, kCorners, kWalls, {OffsetOf(0, 1, 1, {0, 1}, 0), OffsetOf(1, 2, 0, {1, 0}, 0)}, {});
  const Displacement end = springs.At({kCorners[2], {2, -1}, {1, 0}});
  EXPECT_NEAR(end.covariance(1, 1), 0.5, 0.02);   // along 5 m of wall
  EXPECT_NEAR(end.covariance(0, 0), 0.05, 0.01);  // across it
}

TEST(WallSprings, AWallThatContradictsTheOthersIsSurprising) {
  std::vector<PlanOffset> offsets = {OffsetOf(0, 1, 0.2, {0, 1}, 0), OffsetOf(0, 1, 0.5, {0, 1}, 0),
                                     OffsetOf(0, 1, 0.8, {0, 1}, 0), OffsetOf(1, 2, 0.5, {1, 0}, 3.0)};
  const WallSprings springs({}, kCorners, kWalls, offsets, {});
  offsets.back().offset = 0;
  const WallSprings agreeing({}, kCorners, kWalls, offsets, {});
  const std::vector<int> groups = {0, 0, 0, 1};
  EXPECT_LT(agreeing.SurpriseOf(groups)[1], 1.0);
  EXPECT_GT(springs.SurpriseOf(groups)[1], agreeing.SurpriseOf(groups)[1] + 0.1);
}

}  // namespace
}  // namespace enfilade::prior
