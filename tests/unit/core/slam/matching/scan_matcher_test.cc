// SPDX-License-Identifier: Apache-2.0
#include "core/slam/matching/scan_matcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/slam/matching/motion_model.h"
#include "core/slam/matching/scan_points.h"
#include "core/slam/submaps/robot_rays.h"
#include "core/slam/submaps/submap_grid.h"
#include "tests/support/pose_matchers.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using testing::PoseNear;

const std::vector<testing::Wall>& Room() {
  static const auto walls = testing::WallsFromText({"##########",  //
                                                    "#        #",  //
                                                    "#   ##   #",  //
                                                    "#        #",  //
                                                    "#        #",  //
                                                    "##########"},
                                                   1.0);
  return walls;
}

grid::ScanRays RaysAt(const Pose2& T_world_robot, std::uint64_t seed) {
  return RobotRays(testing::Scan(Room(), T_world_robot, {}, 0, seed), {});
}

// The room as seen from a few places, in the world's frame.
SubmapGrid RoomGrid() {
  SubmapGrid grid(0.05, {});
  int seed = 0;
  for (const Pose2& pose : {Pose2{2, 2, 0}, Pose2{2, 2, 1.5}, Pose2{2.3, 2, 3}, Pose2{2.3, 2, -1.5}, Pose2{7, 3.5, 3},
                            Pose2{7, 3.5, 0.2}, Pose2{7, 1.5, 1.8}, Pose2{7, 1.5, -2}}) {
    EXPECT_TRUE(grid.Insert(pose, RaysAt(pose, ++seed)).ok());
  }
  return grid;
}

LikelihoodField RoomField() {
  LikelihoodField field(0.05, 0.5);
  field.Add(RoomGrid().OccupiedPoints());
  return field;
}

TEST(EvaluateMatch, HasTheDerivativeOfItsCost) {
  const LikelihoodField field = RoomField();
  const auto points = Thinned(RaysAt({2.5, 2.2, 0.4}, 99).hits, 0.05);
  const PosePrior prior{{2.4, 2.3, 0.45}, Eigen::Vector3d(30, 20, 100).asDiagonal()};
  for (const Pose2& pose : {Pose2{2.5, 2.2, 0.4}, Pose2{2.56, 2.13, 0.43}, Pose2{2.3, 2.4, 0.2}}) {
    const MatchCost cost = EvaluateMatch(field, points, pose, prior, {});
    for (int k = 0; k < 3; ++k) {
      const double h = 1e-6;
      const auto shifted = [&](double by) {
        Pose2 p = pose;
        (k == 0 ? p.x : k == 1 ? p.y : p.yaw) += by;
        return EvaluateMatch(field, points, p, prior, {}).value;
      };
      const double numeric = (shifted(h) - shifted(-h)) / (2 * h);
      EXPECT_NEAR(2.0 * cost.gradient[k], numeric, 1e-4 * std::abs(numeric) + 1e-3) << "k " << k;
    }
  }
}

TEST(MatchToField, FindsThePoseToMillimetresFromAFewCellsAway) {
  const LikelihoodField field = RoomField();
  for (const Pose2& truth : {Pose2{2.5, 2.2, 0.4}, Pose2{6.7, 3.0, 2.9}, Pose2{5.0, 1.7, -0.3}}) {
    const auto points = Thinned(RaysAt(truth, 77).hits, 0.05);
    const Pose2 guess = truth * Pose2{0.08, -0.06, 0.05};
    const MatchResult match = MatchToField(field, points, guess, {}, {});
    EXPECT_THAT(match.T_submap_robot, PoseNear(truth, 0.01, 0.004));
    EXPECT_GT(match.matched_share, 0.8);
    EXPECT_TRUE(match.converged);
  }
}

TEST(MatchToField, KnowsThatACorridorSaysNothingAlongIt) {
  LikelihoodField field(0.05, 0.5);
  std::vector<Eigen::Vector2d> walls;
  for (double x = -10; x < 10; x += 0.02) {
    walls.emplace_back(x, 1.0);
    walls.emplace_back(x, -1.0);
  }
  field.Add(walls);
  std::vector<Eigen::Vector2d> points;
  for (double x = -4; x < 4; x += 0.11) {
    points.emplace_back(x, 1.003);
    points.emplace_back(x, -0.997);
  }
  const PosePrior prior{{0.2, 0.1, 0.02}, InformationOf(0.1, 0.1)};
  const MatchResult match = MatchToField(field, points, prior.pose, prior, {});
  EXPECT_NEAR(match.T_submap_robot.x, 0.2, 0.02) << "only the prior knows";
  EXPECT_NEAR(match.T_submap_robot.y, 0.0, 0.01);
  EXPECT_NEAR(match.T_submap_robot.yaw, 0.0, 0.002);
  EXPECT_LT(match.information(0, 0), 0.05 * match.information(1, 1));
}

// Walls are known from noisy hits, and points lie on them to a millimetre: neither tells where along them.
TEST(MatchToField, IsNotFooledByNoiseAlongAWall) {
  SubmapGrid grid(0.05, {});
  std::uint32_t state = 1;
  const auto noise = [&] {  // about 1 cm
    state = state * 1664525U + 1013904223U;
    return (static_cast<double>(state >> 8U) / (1U << 24U) - 0.5) * 0.035;
  };
  grid::ScanRays rays;
  for (double x = -9; x < 9; x += 0.01) {
    rays.hits.emplace_back(x + noise(), 1.0 + noise());
    rays.hits.emplace_back(x + noise(), -1.0 + noise());
  }
  EXPECT_TRUE(grid.Insert({}, rays).ok());
  LikelihoodField field(0.05, 0.5);
  field.Add(grid.OccupiedPoints());
  std::vector<Eigen::Vector2d> points;
  for (double x = -4; x < 4; x += 0.11) {
    points.emplace_back(x, 1.0 + noise());
    points.emplace_back(x, -1.0 + noise());
  }
  const MatchResult match = MatchToField(field, points, {}, {{}, InformationOf(0.1, 0.1)}, {});
  EXPECT_LT(match.information(0, 0), 0.02 * match.information(1, 1));
  EXPECT_GT(match.information(1, 1), 1e4) << "across: 60 beams of 5 cm";
}

// The robot has turned left: of the wall on its left, which is known up to x = 1 m, the scan shows more.
TEST(MatchToField, IsNotPulledToTheEndOfAKnownWallWhereNormalsAreKnown) {
  LikelihoodField field(0.05, 0.5);
  std::vector<Eigen::Vector2d> walls;
  for (double x = -3; x < 3; x += 0.02) {
    if (x < 1) walls.emplace_back(x, 1.0);
    walls.emplace_back(x, -2.0);
  }
  for (double y = -2; y < 0; y += 0.02) walls.emplace_back(-3.0, y);
  field.Add(walls);
  std::vector<Eigen::Vector2d> points;
  for (double y = -2; y < 0; y += 0.06) points.emplace_back(-3.0, y);
  for (double x = -3; x < 2; x += 0.06) points.emplace_back(x, 1.0);
  for (double x = -3; x < 3; x += 0.06) points.emplace_back(x, -2.0);
  const MatchResult pulled = MatchToField(field, points, {}, {}, {});
  EXPECT_GT(pulled.T_submap_robot.translation().norm(), 0.005) << "else this tells nothing";
  const MatchResult match = MatchToField(field, points, {0.03, 0.03, 0.01}, {}, {}, SurfaceNormals(points));
  EXPECT_THAT(match.T_submap_robot, PoseNear(Pose2{}, 0.002, 0.0005));
  EXPECT_LT(match.T_submap_robot.translation().norm(), 0.3 * pulled.T_submap_robot.translation().norm());
}

}  // namespace
}  // namespace enfilade::slam
